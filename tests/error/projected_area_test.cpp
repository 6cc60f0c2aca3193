#include "error/projected_area_error.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <stdexcept>

#include "error/cube_symmetry.h"
#include "error/union_area.h"
#include "math/random.h"

namespace probebake {
namespace {

using test::awkward_directions;
using test::cube_symmetries;
using test::CubeSymmetry;

constexpr double kExact = 1e-13;
const Vec3 kDiagonal = glm::normalize(Vec3(1, 1, 1));

std::vector<Vec3> test_directions() {
    std::vector<Vec3> directions = awkward_directions();
    for (const Vec3& d : even_directions(23)) directions.push_back(d);
    return directions;
}

double largest_difference(const MaskErrors& a, const MaskErrors& b) {
    double largest = 0.0;
    for (size_t mask = 0; mask < kMaskCount; ++mask) {
        const double difference = std::abs(a[mask] - b[mask]);
        if (!(difference <= largest)) largest = difference;
    }
    return largest;
}

TEST(ProjectedArea, EmptyIsOneAndFullIsZeroEverywhere) {
    for (const Vec3& d : test_directions()) {
        const MaskErrors errors = projected_area_errors(d);
        EXPECT_EQ(errors[0], 1.0);
        EXPECT_EQ(errors[255], 0.0);
    }
}

TEST(ProjectedArea, WholeCubeHasTheAreaOfItsFaces) {
    for (const Vec3& d : test_directions()) {
        const double faces = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
        EXPECT_NEAR(projected_areas(d)[255], faces, kExact);
    }
}

TEST(ProjectedArea, AxisViewsCountColumns) {
    for (int axis = 0; axis < 3; ++axis) {
        Vec3 d(0.0);
        d[axis] = 1.0;
        const unsigned behind = 1u << axis;
        const MaskErrors along = projected_area_errors(d);
        const MaskErrors against = projected_area_errors(-d);
        for (unsigned mask = 0; mask < kMaskCount; ++mask) {
            int empty_columns = 0;
            for (unsigned octant = 0; octant < 8; ++octant) {
                if ((octant & behind) != 0) continue;
                if ((mask >> octant & 1) == 0 && (mask >> (octant | behind) & 1) == 0) {
                    ++empty_columns;
                }
            }
            EXPECT_NEAR(along[mask], 0.25 * empty_columns, 1e-15);
            EXPECT_NEAR(against[mask], 0.25 * empty_columns, 1e-15);
        }
    }
}

// The projection of a box with edges (a, b, c) has the area |dx|bc + |dy|ca + |dz|ab.
TEST(ProjectedArea, BoxesHaveTheAreaOfTheirFaces) {
    for (const Vec3& d : test_directions()) {
        const Vec3 s = glm::abs(d) / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
        const MaskErrors e = projected_area_errors(d);
        for (int octant = 0; octant < 8; ++octant) EXPECT_NEAR(e[1u << octant], 0.75, kExact);
        EXPECT_NEAR(e[0b00000011], 1 - (s.x / 4 + s.y / 2 + s.z / 2), kExact);  // bar along x
        EXPECT_NEAR(e[0b10100000], 1 - (s.x / 2 + s.y / 4 + s.z / 2), kExact);  // bar along y
        EXPECT_NEAR(e[0b00100010], 1 - (s.x / 2 + s.y / 2 + s.z / 4), kExact);  // bar along z
        EXPECT_NEAR(e[0b01010101], 1 - (s.x + s.y / 2 + s.z / 2), kExact);      // lower half in x
        EXPECT_NEAR(e[0b11001100], 1 - (s.x / 2 + s.y + s.z / 2), kExact);      // upper half in y
        EXPECT_NEAR(e[0b00001111], 1 - (s.x / 2 + s.y / 2 + s.z), kExact);      // lower half in z
    }
}

// From the diagonal all children are regular hexagons of half size: 0 and 7 in the middle, the
// other six around them, each with a corner in the middle and a corner on the parent's.
TEST(ProjectedArea, DiagonalViewByHand) {
    const MaskErrors e = projected_area_errors(kDiagonal);
    EXPECT_NEAR(e[0b10000001], 0.75, kExact);        // one behind the other
    EXPECT_NEAR(e[0b00000011], 7.0 / 12.0, kExact);  // a bar
    EXPECT_NEAR(e[0b01101001], 0.25, kExact);        // 0 and every other one of the six
    EXPECT_NEAR(e[0b01111110], 0.0, kExact);         // the six hide the middle
    EXPECT_NEAR(e[0b00010110], 0.25, kExact);        // every other one of the six alone
    EXPECT_NEAR(e[0b11111110], 0.0, kExact);         // 0 is behind 7
}

// Measured: 4e-15.
TEST(ProjectedArea, AgreesWithASweepOfTheOutlines) {
    for (const Vec3& d : test_directions()) {
        EXPECT_LT(largest_difference(projected_area_errors(d), test::swept_errors(d)), 1e-13)
            << d.x << " " << d.y << " " << d.z;
    }
}

/// Largest |z| over the masks of hit counts against the errors claimed. `rays` random parallel
/// rays are tested against every child box; where the claim leaves no variance, one ray is sigma.
double largest_z_score(const Vec3& d, const MaskErrors& claimed, int rays, RandomStream random) {
    const Vec3 right = glm::normalize(glm::cross(d, Vec3(0.31, 0.17, -0.5)));
    const Vec3 up = glm::cross(d, right);
    std::array<int, kMaskCount> within{};
    for (int i = 0; i < rays;) {
        const double x = 1.8 * random.uniform() - 0.9;
        const double y = 1.8 * random.uniform() - 0.9;
        const Vec3 p = x * right + y * up;
        const auto hits = [&](const Vec3& low, double side) {
            double enter = -1e300;
            double leave = 1e300;
            for (int a = 0; a < 3; ++a) {
                const double t0 = (low[a] - p[a]) / d[a];
                const double t1 = (low[a] + side - p[a]) / d[a];
                enter = std::max(enter, std::min(t0, t1));
                leave = std::min(leave, std::max(t0, t1));
            }
            return enter < leave;
        };
        if (!hits(Vec3(-0.5), 1.0)) continue;
        ++i;
        unsigned met = 0;
        for (unsigned c = 0; c < 8; ++c) {
            const Vec3 low(0.5 * (c & 1) - 0.5, 0.25 * (c & 2) - 0.5, 0.125 * (c & 4) - 0.5);
            if (hits(low, 0.5)) met |= 1u << c;
        }
        ++within[met];
    }
    sum_over_subsets(within);
    double largest = 0.0;
    for (size_t mask = 0; mask < kMaskCount; ++mask) {
        const double share = static_cast<double>(within[255 - mask]) / rays;
        const double variance = std::max(claimed[mask] * (1.0 - claimed[mask]), 1.0 / rays);
        const double z = (share - claimed[mask]) / std::sqrt(variance / rays);
        largest = std::max(largest, std::abs(z));
    }
    return largest;
}

// With 400,000 rays the standard deviation of a mask is 0.0008 or less. |z| ≤ 5 over 4 × 256 cells
// (which fresh seeds would break once in 1,700 runs) lets no bias of 0.006 pass: one is planted.
TEST(ProjectedArea, AgreesWithRandomRays) {
    constexpr int kRays = 400'000;
    uint64_t stream = 0;
    for (const Vec3& d : {kDiagonal, glm::normalize(Vec3(1, -2, 0.5)),
                          glm::normalize(Vec3(-0.1, 0.05, 1)), glm::normalize(Vec3(1, 1, -0.02))}) {
        const RandomStream random(random_key({0x9A7EAu, stream++}));
        const MaskErrors exact = projected_area_errors(d);
        EXPECT_LT(largest_z_score(d, exact, kRays, random), 5.0);
        MaskErrors biased = exact;
        biased[0b00010001] += 0.006;
        EXPECT_GT(largest_z_score(d, biased, kRays, random), 5.0);
    }
}

TEST(ProjectedArea, KeepsAllSymmetriesOfTheCube) {
    const std::vector<CubeSymmetry> symmetries = cube_symmetries();
    ASSERT_EQ(symmetries.size(), 48u);
    for (const Vec3& d : test_directions()) {
        const MaskErrors errors = projected_area_errors(d);
        double largest = 0.0;
        for (const CubeSymmetry& s : symmetries) {
            const MaskErrors image = projected_area_errors(s(d));
            for (unsigned mask = 0; mask < kMaskCount; ++mask) {
                largest = std::max(largest,
                                   std::abs(image[s(static_cast<uint8_t>(mask))] - errors[mask]));
            }
        }
        EXPECT_LT(largest, kExact);
    }
}

TEST(ProjectedArea, HasTwentyTwoClassesOfMasks) {
    std::set<uint8_t> lowest_images;
    for (unsigned mask = 0; mask < kMaskCount; ++mask) {
        uint8_t lowest = 255;
        for (const CubeSymmetry& s : cube_symmetries()) {
            lowest = std::min(lowest, s(static_cast<uint8_t>(mask)));
        }
        lowest_images.insert(lowest);
    }
    EXPECT_EQ(lowest_images.size(), 22u);
}

TEST(ProjectedArea, IsTheSameFromBehind) {
    for (const Vec3& d : test_directions()) {
        EXPECT_LT(largest_difference(projected_area_errors(d), projected_area_errors(-d)), kExact);
    }
}

TEST(ProjectedArea, NeverRisesWhenAChildIsAdded) {
    for (const Vec3& d : test_directions()) {
        const MaskErrors errors = projected_area_errors(d);
        for (size_t mask = 0; mask < kMaskCount; ++mask) {
            for (size_t bit = 1; bit < kMaskCount; bit *= 2) {
                EXPECT_LE(errors[mask | bit], errors[mask] + 1e-14);
            }
        }
    }
}

TEST(ProjectedArea, RefusesDirectionsThatAreNotUnit) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInf = std::numeric_limits<double>::infinity();
    for (const Vec3& d :
         {Vec3(0.0), Vec3(1, 1, 0), Vec3(kNan, 0, 1), Vec3(0, kInf, 0), Vec3(1.00001, 0, 0)}) {
        EXPECT_THROW(projected_area_errors(d), std::invalid_argument);
        EXPECT_THROW(projected_area_errors(std::vector<Vec3>{kDiagonal, d}), std::invalid_argument);
    }
    EXPECT_NO_THROW(projected_area_errors(Vec3(0.577350, 0.577350, 0.577350)));
}

TEST(ChildMask, MirrorsAxisByAxis) {
    for (unsigned axes = 0; axes < 8; ++axes) {
        for (unsigned octant = 0; octant < 8; ++octant) {
            EXPECT_EQ(mirror_mask(static_cast<uint8_t>(1u << octant), axes), 1u << (octant ^ axes));
        }
    }
    EXPECT_EQ(mirror_mask(0b00001011, 5), 0b01110000);
}

TEST(EvenDirections, AreUnitAndEvenlySpread) {
    const std::vector<Vec3> directions = even_directions();
    ASSERT_EQ(directions.size(), 256u);
    EXPECT_NO_THROW(require_unit(directions));
    Vec3 mean(0.0);
    Vec3 square(0.0);
    double nearest = 4.0;
    for (const Vec3& d : directions) {
        mean += d / 256.0;
        square += d * d / 256.0;
        for (const Vec3& other : directions) {
            if (&other != &d) nearest = std::min(nearest, glm::distance(d, other));
        }
    }
    EXPECT_LT(glm::length(mean), 2e-3);
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(square[a], 1.0 / 3.0, 5e-4);
    // No 256 points are further apart than 0.238 (hexagonal packing).
    EXPECT_GT(nearest, 0.18);
    EXPECT_THROW(even_directions(0), std::invalid_argument);
}

}  // namespace
}  // namespace probebake
