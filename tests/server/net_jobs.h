// Jobs in a small generated world: a sagging net of one-voxel ropes, 16 m wide, loaded in 10 ms.
#pragma once

#include <filesystem>
#include <string>

#include "bake/job_spec.h"
#include "support/temp_folder.h"

namespace probebake::test {

/// A scene library with the world "net", a slow one to load ("slow", 2 s), and a broken file.
inline void write_scenes(const std::filesystem::path& folder) {
    write_text(folder / "net.json", R"({"type": "generator", "generator": "net", "size": 64})");
    write_text(folder / "slow.json",
               R"({"type": "generator", "generator": "forest", "size": 512})");
    write_text(folder / "broken.json", R"({"type": "generator", "generator": "atlantis"})");
}

/// `probes` probes in a row above the net, with a target that is quickly met.
inline Json net_request(int probes = 2, int face_size_px = 8) {
    Json request = {{"scene", "net"}, {"face_size_px", face_size_px}, {"seed", 5}};
    request["quality"]["targets"] = {{"psnr_db", 20.0}};
    for (int i = 0; i < probes; ++i) {
        request["probes"]["list"].push_back(
            {{"id", "p" + std::to_string(i)},
             {"position_m", {2.1 + 12.0 * i / probes, 3.6, 7.3 + 0.05 * (i % 16)}}});
    }
    return request;
}

/// A grid "g" of counts probes over the net, with its atlases.
inline Json grid_request(int x, int y, int z) {
    Json request = net_request(1);
    request["probes"] = {{"grids",
                          {{{"id", "g"},
                            {"origin_m", {2.1, 3.6, 7.3}},
                            {"spacing_m", {1.25, 0.5, 0.25}},
                            {"counts", {x, y, z}}}}}};
    request["products"] = {"cube", "ddgi"};
    return request;
}

/// The same with settings of its own, so that every probe costs a good deal: 256 leaf rays a pixel,
/// no pilot, no audit.
inline Json costly_request(int probes, int face_size_px) {
    Json request = net_request(probes, face_size_px);
    request["quality"] = {{"renderer", "reference"},
                          {"settings", {{"leaf_grid", 16}}},
                          {"evidence", {{"audit", false}}}};
    return request;
}

}  // namespace probebake::test
