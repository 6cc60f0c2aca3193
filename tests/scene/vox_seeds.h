// Small well-formed .vox files, together with everything that the importer reads: the corpus that
// the fuzz target starts from (tests/fuzz/corpus/vox) and what the hostile tests damage.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "scene/vox_writer.h"

namespace probebake::test {

/// Every chunk that the importer reads.
inline VoxWriter every_chunk() {
    VoxContent index_map;
    for (int i = 0; i < 256; ++i) index_map.u8(static_cast<uint8_t>(i + 1));
    return VoxWriter()
        .chunk("PACK", VoxContent().i32(2))
        .model({2, 2, 2}, {{0, 0, 0, 1}, {1, 1, 1, 2}})
        .model({1, 1, 1}, {{0, 0, 0, 3}})
        .transform(0, 1)
        .group(1, {2, 4})
        .transform(2, 3, {{"_t", "1 2 3"}, {"_r", "17"}}, {{"_name", "a"}}, 0)
        .shape(3, 0)
        .transform(4, 5, {}, {{"_hidden", "1"}}, 1)
        .shape(5, 1)
        .layer(0, {{"_name", "first"}})
        .layer(1, {{"_hidden", "1"}})
        .palette()
        .chunk("IMAP", index_map)
        .material(1, {{"_type", "_emit"}, {"_emit", "0.5"}, {"_flux", "2"}})
        .chunk("NOTE", VoxContent().i32(0));
}

/// By file name.
inline std::vector<std::pair<std::string, Bytes>> vox_seeds() {
    std::vector<std::pair<std::string, Bytes>> seeds;
    seeds.emplace_back("every_chunk.bin", every_chunk().file());
    seeds.emplace_back("old_file.bin",
                       VoxWriter().model({3, 4, 5}, {{0, 0, 0, 1}, {2, 3, 4, 255}}).file());
    seeds.emplace_back("two_frames.bin", VoxWriter()
                                             .chunk("PACK", VoxContent().i32(2))
                                             .model({1, 1, 1}, {{0, 0, 0, 1}})
                                             .model({256, 256, 256}, {{255, 255, 255, 2}})
                                             .file());
    seeds.emplace_back("two_models.bin", VoxWriter()
                                             .model({2, 1, 1}, {{0, 0, 0, 1}, {1, 0, 0, 0}})
                                             .model({1, 2, 1}, {{0, 1, 0, 3}, {0, 1, 0, 4}})
                                             .transform(0, 1)
                                             .group(1, {2, 4, 2})
                                             .transform(2, 3, {{"_t", "-5 0 7"}, {"_r", "105"}})
                                             .shape(3, 0)
                                             .transform(4, 5, {{"_r", "33"}})
                                             .shape(5, 1)
                                             .file(200));
    VoxWriter shared = VoxWriter().model({1, 1, 1}, {{0, 0, 0, 1}});
    for (int level = 0; level < 6; ++level) shared.group(level, {level + 1, level + 1});
    seeds.emplace_back("shared_groups.bin", shared.shape(6, 0).file());
    seeds.emplace_back(
        "materials.bin",
        VoxWriter()
            .model({2, 1, 1}, {{0, 0, 0, 1}, {1, 0, 0, 2}})
            .material(1, {{"_type", "_emit"}, {"_emit", "1"}, {"_flux", "4"}, {"_ldr", "0.8"}})
            .material(2, {{"_type", "_emit"}, {"_weight", "1e-3"}})
            .material(256, {{"_type", "_glass"}, {"_alpha", "0.5"}})
            .chunk("MATT", VoxContent().i32(1).i32(3))
            .file());
    return seeds;
}

}  // namespace probebake::test
