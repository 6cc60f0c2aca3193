#include "error/ray_cast_error.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <bit>
#include <stdexcept>

#include "error/cube_symmetry.h"
#include "error/error_study.h"
#include "error/projected_area_error.h"

namespace probebake {
namespace {

using test::awkward_directions;

const ErrorTable& exact_table() {
    static const ErrorTable table = projected_area_errors(even_directions());
    return table;
}
const ErrorTable& thesis_table() {
    static const ErrorTable table = ray_cast_errors(even_directions());
    return table;
}

/// Measured at 512 × 512 over 256 directions × 256 masks: mean +2.0e-5, rms 8.6e-5, max 4.0e-4.
bool is_accurate(const ErrorTable& table) {
    const Deviation d = deviation(table, exact_table());
    return std::abs(d.mean) < 3e-5 && d.rms < 1e-4 && d.max < 4.5e-4;
}

TEST(RayCastError, EmptyIsOneAndFullIsZero) {
    for (const MaskErrors& errors : thesis_table().errors) {
        EXPECT_EQ(errors[0], 1.0);
        EXPECT_EQ(errors[255], 0.0);
    }
}

TEST(RayCastError, IsCloseToTheExactTable) { EXPECT_TRUE(is_accurate(thesis_table())); }

// What the bounds above can see: a shift of every value by 6e-5 (less than the noise of one cell),
// a single mask of a single direction off by 1e-3, masks read in another bit order.
TEST(RayCastError, PlantedBiasesAreSeen) {
    ErrorTable shifted = thesis_table();
    for (MaskErrors& errors : shifted.errors) {
        for (double& e : errors) e += 6e-5;
    }
    EXPECT_FALSE(is_accurate(shifted));

    ErrorTable one_cell = thesis_table();
    one_cell.errors[200][0b00011000] += 1e-3;
    EXPECT_FALSE(is_accurate(one_cell));

    ErrorTable mirrored = thesis_table();
    for (size_t n = 0; n < mirrored.errors.size(); ++n) {
        for (size_t mask = 0; mask < kMaskCount; ++mask) {
            const uint8_t image = mirror_mask(static_cast<uint8_t>(mask), 1);
            mirrored.errors[n][mask] = thesis_table().errors[n][image];
        }
    }
    EXPECT_FALSE(is_accurate(mirrored));
}

// A frame of twice the side divides the rms error by 2.6 to 2.8 (cells that straddle an edge err:
// 2^1.5). Plain random samples would divide it by 2.
TEST(RayCastError, SamplesAreStratified) {
    double coarser = deviation(ray_cast_errors(even_directions(), 64), exact_table()).rms;
    for (const int frame_px : {128, 256, 512}) {
        const ErrorTable table =
            frame_px == 512 ? thesis_table() : ray_cast_errors(even_directions(), frame_px);
        const double rms = deviation(table, exact_table()).rms;
        EXPECT_GT(coarser / rms, 2.4) << frame_px;
        coarser = rms;
    }
}

TEST(RayCastError, NeverRisesWhenAChildIsAdded) {
    for (const MaskErrors& errors : thesis_table().errors) {
        for (size_t mask = 0; mask < kMaskCount; ++mask) {
            for (size_t bit = 1; bit < kMaskCount; bit *= 2) {
                ASSERT_LE(errors[mask | bit], errors[mask]);
            }
        }
    }
}

TEST(RayCastError, IsTheSameFromBehind) {
    std::vector<Vec3> behind = even_directions();
    for (Vec3& d : behind) d = -d;
    EXPECT_LT(deviation(ray_cast_errors(behind), thesis_table()).max, 8e-4);
}

TEST(RayCastError, AwkwardDirectionsAreAsAccurateAsOthers) {
    const ErrorTable table = ray_cast_errors(awkward_directions());
    const Deviation d = deviation(table, projected_area_errors(awkward_directions()));
    EXPECT_LT(d.max, 1.5e-3);
    EXPECT_LT(d.rms, 4e-4);
}

TEST(RayCastError, SameBytesForOneAndFourThreads) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
    ErrorTable one;
    ErrorTable four;
    tbb::task_arena(1).execute([&] { one = ray_cast_errors(even_directions(), 128); });
    tbb::task_arena(4).execute([&] { four = ray_cast_errors(even_directions(), 128); });
    ASSERT_EQ(one.errors.size(), four.errors.size());
    for (size_t n = 0; n < one.errors.size(); ++n) {
        for (size_t mask = 0; mask < kMaskCount; ++mask) {
            ASSERT_EQ(std::bit_cast<uint64_t>(one.errors[n][mask]),
                      std::bit_cast<uint64_t>(four.errors[n][mask]));
        }
    }
}

TEST(RayCastError, RefusesFramesAndDirectionsItCannotCast) {
    for (const int frame_px : {-2, 0, 6, 63, 4098}) {
        EXPECT_THROW(ray_cast_errors(even_directions(1), frame_px), std::invalid_argument);
    }
    EXPECT_NO_THROW(ray_cast_errors(even_directions(1), 8));
    EXPECT_THROW(ray_cast_errors({Vec3(0, 0, 2)}, 64), std::invalid_argument);
    EXPECT_TRUE(ray_cast_errors({}, 64).errors.empty());
}

}  // namespace
}  // namespace probebake
