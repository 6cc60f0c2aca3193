// Grids on disk: read back as they were written, or refused.
#include "volume/grid_file.h"

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/io_error.h"
#include "support/temp_folder.h"

namespace probebake {
namespace {

/// Constant, empty and full bricks; `step` decides whether halves hold it.
DensityGrid grid(float step) {
    return DensityGrid({{-3, 2, 5}, {30, 20, 10}}, [&](const IVec3& low, auto values) {
        if (low.x > 15) return false;
        for (size_t i = 0; i < values.size(); ++i) {
            values[i] = low.y > 5 ? 0.75f : step * static_cast<float>(i % 7);
        }
        return true;
    });
}

TEST(GridFile, ReadsBackHalvesAndFloats) {
    const test::TempFolder folder;
    for (const float step : {0.5f, 0.1f}) {
        const DensityGrid made = grid(step);
        EXPECT_EQ(made.is_half(), step == 0.5f);
        const Affine place{glm::dmat3(2.0), {1.0, 2.0, 3.0}};
        save_grid(folder.path() / "a.density", made, place);
        const PlacedGrid read = load_grid(folder.path() / "a.density");
        EXPECT_EQ(read.index_to_world.linear, place.linear);
        EXPECT_EQ(read.index_to_world.offset, place.offset);
        EXPECT_EQ(read.grid.memory_bytes(), made.memory_bytes());
        for (int i = 0; i < 2000; ++i) {
            const Vec3 at(-4.0 + 0.017 * i, 1.0 + 0.011 * i, 4.0 + 0.006 * i);
            ASSERT_EQ(read.grid.sample(at), made.sample(at));
        }
    }
}

TEST(GridFile, DamageAndArraysThatDoNotFitAreRefused) {
    const test::TempFolder folder;
    const std::filesystem::path path = folder.path() / "a.density";
    save_grid(path, grid(0.1f), {});
    std::vector<std::byte> bytes = read_file(path);
    bytes[bytes.size() / 2] ^= std::byte{1};
    write_file_atomically(path, bytes);
    EXPECT_THROW(load_grid(path), IoError);

    const DensityGrid good = grid(0.1f);
    const auto arrays = [&] {
        return DensityGrid::Arrays{good.low(),
                                   good.cells(),
                                   {good.table().begin(), good.table().end()},
                                   {good.constants().begin(), good.constants().end()},
                                   {good.floats().begin(), good.floats().end()},
                                   {}};
    };
    EXPECT_NO_THROW(DensityGrid{arrays()});
    const auto refused = [&](const auto& change) {
        DensityGrid::Arrays bad = arrays();
        change(bad);
        EXPECT_THROW(DensityGrid(std::move(bad)), std::invalid_argument);
    };
    refused([](DensityGrid::Arrays& a) { a.table.pop_back(); });
    refused([](DensityGrid::Arrays& a) { a.table[0] = 1000; });
    refused([](DensityGrid::Arrays& a) { a.constants.clear(); });
    refused([](DensityGrid::Arrays& a) { a.floats.pop_back(); });
    refused([](DensityGrid::Arrays& a) { a.floats[5] = -1.0f; });
    refused([](DensityGrid::Arrays& a) { a.halves.assign(a.floats.size(), 0); });
}

}  // namespace
}  // namespace probebake
