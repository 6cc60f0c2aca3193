// OpenVDB files with numbers that are none, written by the library itself.
#include <openvdb/openvdb.h>
#include <unistd.h>

#include <limits>

#include "scene/vdb/vdb_file.h"
#include "volume_study/stability.h"

namespace probebake::volume_study {

std::vector<StabilityCase> vdb_cases() {
    openvdb::initialize();
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() /
        ("probebake-stability-" + std::to_string(::getpid()) + ".vdb");
    int tried = 0;
    int refused = 0;
    const auto expect_refusal = [&](const openvdb::FloatGrid::Ptr& grid) {
        grid->setName("density");
        try {
            openvdb::io::File(path.string()).write({grid});
        } catch (const std::exception&) {
            return;  // the library does not write that
        }
        ++tried;
        try {
            read_vdb_grid(path, "density");
        } catch (const IoError&) {
            ++refused;
        }
    };
    const auto grid_with = [](float value) {
        auto grid = openvdb::FloatGrid::create(0.0f);
        grid->tree().setValue(openvdb::Coord(1, 2, 3), 0.5f);
        grid->tree().setValue(openvdb::Coord(2, 2, 3), value);
        return grid;
    };
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInfinite = std::numeric_limits<float>::infinity();
    for (const float bad : {kNan, kInfinite, -kInfinite}) {
        expect_refusal(grid_with(bad));
        auto tile = grid_with(0.5f);
        tile->tree().addTile(1, openvdb::Coord(32, 0, 0), bad, true);
        expect_refusal(tile);
        expect_refusal(openvdb::FloatGrid::create(bad));  // the background
        for (const int entry : {0, 5, 12}) {              // scale, shear or turn, shift
            auto map = openvdb::Mat4d::identity();
            map(entry / 4, entry % 4) = double{bad};
            auto moved = grid_with(0.5f);
            try {
                moved->setTransform(std::make_shared<openvdb::math::Transform>(
                    openvdb::math::MapBase::Ptr(std::make_shared<openvdb::math::AffineMap>(map))));
            } catch (const std::exception&) {
                continue;  // nor has it such a map
            }
            expect_refusal(moved);
        }
    }
    std::filesystem::remove(path);
    return {at_least("NaN anywhere in the input",
                     "values, tiles, background and transforms of .vdb files: refused, of " +
                         std::to_string(tried),
                     refused, tried)};
}

}  // namespace probebake::volume_study
