// The octahedral map and its border.
#include "image/octahedral.h"

#include <gtest/gtest.h>

#include <cmath>

#include "math/random.h"

namespace probebake {
namespace {

TEST(Octahedral, AxesLieWhereRtxgiHasThem) {
    const auto at = [](const Vec3& d) { return octahedral_point(d); };
    EXPECT_EQ(at({0, 0, 1}), Vec2(0, 0));
    EXPECT_EQ(at({1, 0, 0}), Vec2(1, 0));  // to the right
    EXPECT_EQ(at({0, 1, 0}), Vec2(0, 1));  // down
    EXPECT_EQ(at({-1, 0, 0}), Vec2(-1, 0));
    EXPECT_EQ(at({0, -1, 0}), Vec2(0, -1));
    EXPECT_EQ(glm::abs(at({0, 0, -1})), Vec2(1, 1));  // the corners
    // The first texel of six, at (−5/6, −5/6), is folded to (−1/6, −1/6, −2/3).
    const Vec3 first = octahedral_texel_direction(0, 0, 6);
    EXPECT_LT(glm::length(first - glm::normalize(Vec3(-1, -1, -4))), 1e-12);
}

TEST(Octahedral, PointsAndDirectionsAreInverses) {
    RandomStream random(3);
    for (int i = 0; i < 10'000; ++i) {
        const Vec2 p(2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0);
        const Vec3 d = octahedral_direction(p.x, p.y);
        ASSERT_NEAR(glm::length(d), 1.0, 1e-12);
        ASSERT_LT(glm::length(octahedral_point(d) - p), 1e-12);
    }
}

/// Bilinear at a point of the square, as a GPU looks it up in a tile.
Vec3 look_up(const Image& tile, const Vec2& point) {
    const int inside_px = tile.width() - 2;
    const Vec2 at = (point + 1.0) * (inside_px / 2.0) + 0.5;  // of texel centres
    const int x = static_cast<int>(at.x);
    const int y = static_cast<int>(at.y);
    const auto texel = [&](int i, int j) { return Vec3(tile.at(x + i, y + j)); };
    return glm::mix(glm::mix(texel(0, 0), texel(1, 0), at.x - x),
                    glm::mix(texel(0, 1), texel(1, 1), at.x - x), at.y - y);
}

// A point of the square's edge and the one mirrored along that edge are the same direction, and all
// four corners are: whatever a tile holds, lookups must agree there. With a border that is not
// flipped, or one texel off, they do not.
TEST(Octahedral, LookupsDoNotSeeTheEdges) {
    for (const int inside_px : {6, 14}) {
        RandomStream random(5);
        Image tile(inside_px + 2, inside_px + 2);
        for (Rgb& texel : tile.pixels()) texel = Rgb(static_cast<float>(random.uniform()));
        fill_octahedral_border(tile, 0, 0, inside_px);
        Image not_flipped = tile;
        for (int i = 1; i <= inside_px; ++i) not_flipped.at(i, 0) = tile.at(i, 1);
        double largest_wrong = 0.0;
        const double last = 1.0 - 1e-9;  // the last texel's neighbour is inside the tile
        for (int i = 0; i < 1000; ++i) {
            const double s = last * (2.0 * random.uniform() - 1.0);
            for (const double end : {-last, last}) {
                EXPECT_LT(glm::length(octahedral_direction(s, end) - octahedral_direction(-s, end)),
                          1e-8);
                EXPECT_LT(glm::length(look_up(tile, {s, end}) - look_up(tile, {-s, end})), 1e-6);
                EXPECT_LT(glm::length(look_up(tile, {end, s}) - look_up(tile, {end, -s})), 1e-6);
            }
            const Vec3 wrong = look_up(not_flipped, {s, -last}) - look_up(not_flipped, {-s, -last});
            largest_wrong = std::max(largest_wrong, glm::length(wrong));
        }
        EXPECT_GT(largest_wrong, 0.2);
        for (const Vec2& corner : {Vec2(last, last), Vec2(-last, last), Vec2(last, -last)}) {
            EXPECT_LT(glm::length(look_up(tile, corner) - look_up(tile, {-last, -last})), 1e-6);
        }
    }
}

// Interpolated directions are near the ones looked up, over the whole sphere: what remains are the
// creases between octants, and texels that are turned or mirrored would be off by 1 and more.
TEST(Octahedral, LookupsFindTheirDirection) {
    for (const auto& [inside_px, tolerance] : {std::pair{6, 0.25}, std::pair{14, 0.1}}) {
        Image tile(inside_px + 2, inside_px + 2);
        for (int y = 0; y < inside_px; ++y) {
            for (int x = 0; x < inside_px; ++x) {
                tile.at(x + 1, y + 1) = Rgb(octahedral_texel_direction(x, y, inside_px));
            }
        }
        fill_octahedral_border(tile, 0, 0, inside_px);
        RandomStream random(6);
        double largest = 0.0;
        for (int i = 0; i < 20'000; ++i) {
            const Vec2 point(2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0);
            const Vec3 exact = octahedral_direction(point.x, point.y);
            largest = std::max(largest, glm::length(look_up(tile, point) - exact));
        }
        std::printf("%d texels: off by %.3f at most\n", inside_px, largest);
        EXPECT_LT(largest, tolerance);
    }
}

// The border as RTXGI's figure has it: numbers are those of inside texels, row by row from 0.
TEST(Octahedral, TheBorderIsAsInRtxgisFigure) {
    Image tile(8, 8);
    for (int y = 0; y < 6; ++y) {
        for (int x = 0; x < 6; ++x) tile.at(x + 1, y + 1) = Rgb(static_cast<float>(6 * y + x));
    }
    fill_octahedral_border(tile, 0, 0, 6);
    const auto row = [&](int y) {
        std::vector<int> values;
        values.reserve(8);
        for (int x = 0; x < 8; ++x) values.push_back(static_cast<int>(tile.at(x, y).r));
        return values;
    };
    EXPECT_EQ(row(0), (std::vector{35, 5, 4, 3, 2, 1, 0, 30}));
    EXPECT_EQ(row(1), (std::vector{30, 0, 1, 2, 3, 4, 5, 35}));
    EXPECT_EQ(row(6), (std::vector{0, 30, 31, 32, 33, 34, 35, 5}));
    EXPECT_EQ(row(7), (std::vector{5, 35, 34, 33, 32, 31, 30, 0}));
}

}  // namespace
}  // namespace probebake
