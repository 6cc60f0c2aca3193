// The specular chain: its mips, its cubes, and what Filament makes of the same map.
#include "image/specular.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstdio>

#include "image/cubemaps.h"
#include "image/exr.h"
#include "image/layouts.h"
#include "image/rgb_file.h"
#include "image/tools.h"
#include "io/file.h"

namespace probebake {
namespace {

TEST(Specular, ChainsEndAtSixteenPixels) {
    EXPECT_EQ(specular_mips(1), 1);
    EXPECT_EQ(specular_mips(2), 1);
    EXPECT_EQ(specular_mips(16), 1);
    EXPECT_EQ(specular_mips(31), 1);
    EXPECT_EQ(specular_mips(32), 2);
    EXPECT_EQ(specular_mips(48), 2);  // 48, 24
    EXPECT_EQ(specular_mips(64), 3);
    EXPECT_EQ(specular_mips(512), 6);
    EXPECT_EQ(specular_mips(4096), 9);
    EXPECT_EQ(specular_roughness(0, 1), 0.0);
    EXPECT_EQ(specular_roughness(1, 3), 0.5);
    EXPECT_EQ(specular_roughness(5, 6), 1.0);
}

// What comes out can be written: edges shared, nothing negative; a lamp of 10⁶ makes a mip FLOAT
// only where its mean exceeds HALF.
TEST(Specular, MipsAreCubemaps) {
    for (const int n : {1, 2, 4, 16, 17, 64}) {
        Cubemap cube = test::random_cubemap(n, 8);
        cube.at(owner_of({CubeFace::kPosZ, n / 2, n / 2}, n)) = Rgb(1e6f);
        cube.share_edges();
        const SphereFilter filter(cube);
        for (const int size : {1, 2, 16, 33}) {
            const Cubemap sharp = specular_of(filter, 0.05, size);
            const Cubemap rough = specular_of(filter, 1.0, size);
            EXPECT_EQ(rough.face_size(), size);
            EXPECT_NO_THROW(encode_cubemap(sharp, {}));
            EXPECT_NO_THROW(encode_cubemap(rough, {}));
            if (n == 64) {
                EXPECT_FALSE(encode_cubemap(rough, {}).is_float);
            }
        }
    }
}

TEST(Specular, AConstantIsExactInTheFile) {
    for (const int n : {1, 2, 4, 16, 64}) {
        const Cubemap cube =
            test::make_cubemap(n, [](const CubePixel&) { return Rgb(0.3f, 1000.0f, 0.0f); });
        const SphereFilter filter(cube);
        for (const double alpha : {0.04, 0.25, 1.0}) {
            EXPECT_EQ(rounded_to_file(specular_of(filter, alpha, n)), rounded_to_file(cube)) << n;
        }
    }
}

TEST(Specular, TheSameBytesForAnyNumberOfThreads) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    const Cubemap cube = test::wave_cubemap(64);
    std::vector<std::byte> first;
    for (const int threads : {1, 7}) {
        tbb::task_arena arena(threads);
        std::vector<std::byte> bytes;
        arena.execute(
            [&] { bytes = encode_cubemap(specular_of(SphereFilter(cube), 0.25, 32), {}).bytes; });
        if (first.empty()) first = bytes;
        EXPECT_EQ(bytes, first) << threads;
    }
}

// A cell's error falls with N. At 512 only some texels are looked at: the sum over all pixels takes
// a hundredth of a second for each.
TEST(Specular, AFineChainIsFastAndRight) {
    const int n = 512;
    Cubemap cube = test::wave_cubemap(n);
    cube.at({CubeFace::kPosX, n / 3, n / 5}) = Rgb(1e6f);
    const auto start = std::chrono::steady_clock::now();
    const SphereFilter filter(cube);
    const double alpha = 0.04;  // of mip 1 of 6
    const Cubemap mip = specular_of(filter, alpha, 64);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::printf("%.2f s for %d texels of alpha 0.04\n", seconds, int(owned_pixel_count(64)));
    std::vector<double> solid_angles;
    solid_angles.reserve(static_cast<size_t>(n * n));
    for (int i = 0; i < n * n; ++i) solid_angles.push_back(pixel_solid_angle(i % n, i / n, n));
    double largest = 0.0;
    for (int i = 0; i < 12; ++i) {
        const CubePixel at{CubeFace::kPosX, 64 / 3 - 6 + i, 64 / 5 + i % 3};
        const Vec3 normal = test::pixel_direction(at, 64);
        double sum = 0.0;
        double weights = 0.0;
        for (size_t p = 0; p < cube.image().pixels().size(); ++p) {
            const CubePixel pixel = pixel_at(p, n);
            const double cosine = glm::dot(normal, test::pixel_direction(pixel, n));
            if (cosine <= 0.0) continue;
            const double d = (alpha * alpha - 1.0) * (1.0 + cosine) / 2.0 + 1.0;
            const double w = cosine / (d * d) * solid_angles[p % solid_angles.size()];
            sum += w * static_cast<double>(cube.image().pixels()[p].g);
            weights += w;
        }
        largest =
            std::max(largest, std::abs(static_cast<double>(mip.at(at).g) * weights / sum - 1.0));
    }
    std::printf("off by %.1e of a texel's value at most\n", largest);
    EXPECT_LT(largest, 0.02);
}

// Filament prefilters our latlong the same way (N = V = R, weights n·l, linear roughness α), but
// spaces its mips otherwise: mip 1 of 3 has α = (1 − 1/√2)², not 1/16; its texels are centred, its
// faces GL's. Without its filtered lookups, which turn what they blur by half a texel of their mip
// (0.022 root mean square of 0.5 + 0.5 d at α = 1, for which the integral is known), its 1024
// samples of a cube of 64² agree with ours at that α and in those directions within half a texel.
TEST(Specular, CmgenFindsTheSame) {
    if (!test::has_tool("cmgen")) GTEST_SKIP() << "cmgen is not installed";
    const test::TemporaryFolder folder;
    const auto path = [&](const std::string& name) { return (folder / name).string(); };
    for (const auto& [name, cube] : {std::pair{"direction", test::direction_cubemap(128)},
                                     std::pair{"waves", test::wave_cubemap(128)}}) {
        write_file_atomically(path(std::string(name) + ".exr"),
                              encode_layout(latlong_of(cube), ExrLayout::kLatlong, {}).bytes);
        const auto run = test::run_tool(
            "cmgen -q --size=64 --format=exr --ibl-no-prefilter --ibl-ld=" + path("out") + " " +
            path(std::string(name) + ".exr"));
        ASSERT_EQ(run.status, 0) << run.text;
        const SphereFilter filter(cube);
        for (const auto& [mip, perceptual] :
             {std::pair{1, 1.0 - std::sqrt(0.5)}, std::pair{2, 1.0}}) {
            const double alpha = perceptual * perceptual;
            double largest = 0.0;
            double square = 0.0;
            for (const CubeFace face : kCubeFaces) {
                const Image theirs = test::read_rgb_file(
                    path("out/" + std::string(name) + "/m" + std::to_string(mip) + "_" +
                         kGlFaceNames[static_cast<size_t>(index_of(face))] + ".exr"));
                const int n = theirs.width();
                for (int y = 0; y < n; ++y) {
                    for (int x = 0; x < n; ++x) {
                        const Vec3 normal = glm::normalize(gl_direction(
                            face, (2.0 * x + 1.0) / n - 1.0, (2.0 * y + 1.0) / n - 1.0));
                        const Vec3 ours =
                            filter.mean(GgxKernel{static_cast<float>(alpha * alpha)}, normal);
                        const Vec3 error = glm::abs(ours - Vec3(theirs.at(x, y)));
                        largest = std::max({largest, error.r, error.g, error.b});
                        square += glm::dot(error, error) / (3.0 * 6.0 * n * n);
                    }
                }
            }
            std::printf("%s, alpha %.3f: rms %.4f, largest %.4f\n", name, alpha, std::sqrt(square),
                        largest);
            EXPECT_LT(std::sqrt(square), 0.01) << name << " " << mip;
            EXPECT_LT(largest, 0.05) << name << " " << mip;
        }
    }
}

}  // namespace
}  // namespace probebake
