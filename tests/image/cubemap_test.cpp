#include "image/cubemap.h"

#include <ImfEnvmap.h>
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <numbers>

#include "image/cubemaps.h"

namespace probebake {
namespace {

using test::pixel_direction;

constexpr std::array kSizes = {1, 2, 3, 4, 16, 64};

std::vector<CubePixel> all_pixels(int n) {
    std::vector<CubePixel> pixels;
    for (const CubeFace face : kCubeFaces) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) pixels.push_back({face, x, y});
        }
    }
    return pixels;
}

/// The direction times N − 1, exactly.
std::array<long, 3> integer_direction(const CubePixel& p, int n) {
    const Vec3 d = static_cast<double>(std::max(n - 1, 1)) *
                   face_direction(p.face, grid_coordinate(p.x, n), grid_coordinate(p.y, n));
    return {std::lround(d.x), std::lround(d.y), std::lround(d.z)};
}

TEST(Cubemap, EveryPixelIsWhereOpenExrHasItsDirection) {
    for (const int n : {2, 3, 4, 16, 64}) {
        const Imath::Box2i window({0, 0}, {n - 1, 6 * n - 1});
        for (const CubePixel& p : all_pixels(n)) {
            // OpenEXR's places in a face are turned against the image; its image is ours.
            const auto face = static_cast<Imf::CubeMapFace>(index_of(p.face));
            const Imath::V2f in_face(static_cast<float>(p.x), static_cast<float>(p.y));
            const Imath::V2f in_image = Imf::CubeMap::pixelPosition(face, window, in_face);
            const Imath::V3f theirs = Imf::CubeMap::direction(face, window, in_face).normalized();
            const auto row = static_cast<int>(std::lround(in_image.y));
            const CubePixel stored{kCubeFaces[static_cast<size_t>(row / n)],
                                   static_cast<int>(std::lround(in_image.x)), row % n};
            const Vec3 ours = pixel_direction(stored, n);
            ASSERT_EQ(stored.face, p.face);
            ASSERT_NEAR(theirs.x, ours.x, 1e-6) << n << " " << row << " " << stored.x;
            ASSERT_NEAR(theirs.y, ours.y, 1e-6) << n << " " << row << " " << stored.x;
            ASSERT_NEAR(theirs.z, ours.z, 1e-6) << n << " " << row << " " << stored.x;
        }
    }
}

TEST(Cubemap, DirectionsFindTheirFacePoint) {
    RandomStream random(5);
    for (int i = 0; i < 60000; ++i) {
        const CubeFace face = kCubeFaces[static_cast<size_t>(i % kFaceCount)];
        const double u = 2.0 * random.uniform() - 1.0;
        const double v = 2.0 * random.uniform() - 1.0;
        const FacePoint point =
            face_point((0.1 + 9.0 * random.uniform()) * face_direction(face, u, v));
        ASSERT_EQ(point.face, face);
        ASSERT_NEAR(point.u, u, 1e-15);
        ASSERT_NEAR(point.v, v, 1e-15);
    }
}

TEST(Cubemap, TiesGoToXThenYThenZ) {
    for (const double x : {-1.0, 1.0}) {
        for (const double y : {-1.0, 1.0}) {
            for (const double z : {-1.0, 1.0}) {
                EXPECT_EQ(axis_of(face_point({x, y, z}).face), 0);
                EXPECT_EQ(axis_of(face_point({x, y, 0.5 * z}).face), 0);
                EXPECT_EQ(axis_of(face_point({x, 0.5 * y, z}).face), 0);
                EXPECT_EQ(axis_of(face_point({0.5 * x, y, z}).face), 1);
            }
        }
    }
    EXPECT_EQ(face_point({0.0, -1.0, 1.0}).face, CubeFace::kNegY);
    EXPECT_EQ(face_point({-1.0, 0.0, 1.0}).face, CubeFace::kNegX);
}

TEST(Cubemap, CoordinatesAreExactlyAntisymmetric) {
    EXPECT_EQ(grid_coordinate(0, 1), 0.0);
    for (int n = 2; n <= 1024; ++n) {
        EXPECT_EQ(grid_coordinate(0, n), -1.0);
        EXPECT_EQ(grid_coordinate(n - 1, n), 1.0);
        for (int x = 0; x < n; ++x) {
            ASSERT_EQ(grid_coordinate(x, n), -grid_coordinate(n - 1 - x, n)) << x << " of " << n;
        }
    }
}

TEST(Cubemap, OwnerIsTheFirstPixelOfTheSameDirection) {
    for (const int n : kSizes) {
        // Pixels come face by face, so the first that has a direction is on the lowest face.
        std::map<std::array<long, 3>, CubePixel> first;
        for (const CubePixel& p : all_pixels(n)) {
            const auto [at, is_new] = first.try_emplace(integer_direction(p, n), p);
            ASSERT_EQ(owner_of(p, n), at->second)
                << n << ": " << kFaceNames[size_t(index_of(p.face))] << " " << p.x << " " << p.y;
            const CubePixel owner = owner_of(p, n);
            ASSERT_EQ(is_new, owner == p);
            // The very same doubles, so that a renderer sees the same rays.
            const Vec3 d = face_direction(p.face, grid_coordinate(p.x, n), grid_coordinate(p.y, n));
            const Vec3 owners = face_direction(owner.face, grid_coordinate(owner.x, n),
                                               grid_coordinate(owner.y, n));
            ASSERT_EQ(d, owners);
        }
        const size_t distinct =
            n == 1 ? 6 : 6 * size_t(n - 2) * size_t(n - 2) + 12 * size_t(n - 2) + 8;
        EXPECT_EQ(first.size(), distinct) << n;
    }
}

TEST(Cubemap, ShareEdgesCopiesTheOwnersAndNothingElse) {
    for (const int n : kSizes) {
        RandomStream random(static_cast<uint64_t>(n));
        Cubemap cubemap(n);
        for (Rgb& c : cubemap.image().pixels()) c = Rgb(static_cast<float>(random.uniform()));
        const Cubemap before = cubemap;
        cubemap.share_edges();
        for (const CubePixel& p : all_pixels(n)) {
            ASSERT_EQ(cubemap.at(p), before.at(owner_of(p, n))) << n;
        }
    }
}

TEST(Cubemap, IndexRunsAsTheImageDoes) {
    Cubemap cubemap(5);
    size_t index = 0;
    for (const CubePixel& p : all_pixels(5)) {
        EXPECT_EQ(cube_index(p, 5), index);
        EXPECT_EQ(&cubemap.at(p), &cubemap.image().pixels()[index]);
        ++index;
    }
}

TEST(Cubemap, SolidAnglesSumToTheSphere) {
    for (const int n : {1, 2, 3, 4, 5, 16, 64, 257}) {
        double sum = 0.0;
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) sum += pixel_solid_angle(x, y, n);
        }
        EXPECT_NEAR(6.0 * sum, 4.0 * std::numbers::pi, 1e-12) << n;
    }
}

TEST(Cubemap, SolidAngleIsTheIntegralOverTheClippedCell) {
    const int n = 6;
    const int steps = 400;
    for (const auto& [x, y] : {std::pair(0, 0), {0, 3}, {2, 2}, {5, 1}}) {
        const double cell = grid_spacing(n);
        double integral = 0.0;
        for (int i = 0; i < steps; ++i) {
            for (int j = 0; j < steps; ++j) {
                const double u = grid_coordinate(x, n) + ((i + 0.5) / steps - 0.5) * cell;
                const double v = grid_coordinate(y, n) + ((j + 0.5) / steps - 0.5) * cell;
                if (std::abs(u) > 1.0 || std::abs(v) > 1.0) continue;
                integral += std::pow(1.0 + u * u + v * v, -1.5) * cell * cell / (steps * steps);
            }
        }
        EXPECT_NEAR(pixel_solid_angle(x, y, n), integral, 1e-6) << x << " " << y;
    }
}

TEST(Cubemap, BilinearSamplesMeetPixelsAndAreContinuousAcrossEdges) {
    for (const int n : {1, 2, 3, 16}) {
        const Cubemap cubemap = test::random_cubemap(n, 3);
        for (const CubePixel& p : all_pixels(n)) {
            const Rgb sample = sample_bilinear(cubemap, pixel_direction(p, n));
            ASSERT_LT(glm::length(sample - cubemap.at(p)), 1e-5f) << n;
        }
        if (n == 1) continue;
        RandomStream random(8);
        for (int i = 0; i < 1000; ++i) {
            // A point of the edge between +X and another face, from both sides.
            const double v = 2.0 * random.uniform() - 1.0;
            const Rgb inside = sample_bilinear(cubemap, {1.0 + 1e-9, v, 1.0});
            const Rgb outside = sample_bilinear(cubemap, {1.0 - 1e-9, v, 1.0});
            ASSERT_LT(glm::length(inside - outside), 1e-5f) << n;
        }
    }
}

TEST(Cubemap, BilinearSamplesOfDirectionsPointThere) {
    const Cubemap cubemap = test::direction_cubemap(64);
    RandomStream random(2);
    for (int i = 0; i < 10000; ++i) {
        const Vec3 d =
            glm::normalize(Vec3(random.uniform(), random.uniform(), random.uniform()) - Vec3(0.5));
        const Vec3 read = 2.0 * Vec3(sample_bilinear(cubemap, d)) - 1.0;
        ASSERT_LT(glm::length(read - d), 3e-4);
    }
}

}  // namespace
}  // namespace probebake
