// What voxels show: filtered textures, holes, emission.
#include <gtest/gtest.h>

#include "mesh/mesh_worlds.h"
#include "mesh/texture_pyramid.h"
#include "mesh/voxelise.h"

namespace probebake {
namespace {

Texture checkers(int width, int height, std::array<uint8_t, 4> a, std::array<uint8_t, 4> b) {
    Texture texture{.width_px = width, .height_px = height, .texels = {}};
    for (int i = 0; i < width * height; ++i) {
        texture.texels.push_back((i % width + i / width) % 2 == 0 ? a : b);
    }
    return texture;
}

Rgb mean_albedo(const VoxelTree& tree) {
    Rgb sum(0.0f);
    const ColorLevels& albedo = tree.colors().albedo;
    for (const PackedRgb packed : albedo.voxels) sum += unpack_rgb(packed);
    return sum / static_cast<float>(albedo.voxels.size());
}

TEST(TexturePyramid, KeepsTheMeanInLinearLightAtEverySize) {
    for (const auto& [width, height] : {std::pair{64, 64}, {37, 5}, {1, 9}, {1, 1}}) {
        Texture texture{.width_px = width, .height_px = height, .texels = {}};
        RandomStream random(random_key({static_cast<uint64_t>(width)}));
        double sum = 0.0;
        for (int i = 0; i < width * height; ++i) {
            const auto value = static_cast<uint8_t>(random.below(256));
            texture.texels.push_back({value, 0, 255, 255});
            sum += value <= 10 ? value / 255.0 / 12.92
                               : std::pow((value / 255.0 + 0.055) / 1.055, 2.4);
        }
        const TexturePyramid pyramid(texture, false);
        const Rgba mean = pyramid.mean(Vec2(0.3, 0.7), glm::dmat2(1e12));
        EXPECT_NEAR(mean.r, sum / (width * height), 2e-4) << width << " x " << height;
        EXPECT_EQ(mean.g, 0.0f);
        EXPECT_NEAR(mean.b, 1.0f, 1e-4f);
    }
}

TEST(TexturePyramid, HolesDoNotColorWhatIsThere) {
    // Green leaves; the holes between them are magenta in the file.
    const Texture texture = checkers(32, 32, {0, 255, 0, 255}, {255, 0, 255, 0});
    const Rgba mean = TexturePyramid(texture, true).mean(Vec2(0.5), glm::dmat2(64.0));
    EXPECT_NEAR(mean.a, 0.5f, 0.02f);
    EXPECT_NEAR(mean.g / mean.a, 1.0f, 1e-3f);
    EXPECT_LT(mean.r, 1e-3f);
}

TEST(VoxelLook, TexturesAreFilteredToTheVoxel) {
    TriangleMesh mesh;
    test::add_material(mesh, Rgb(0.5f));
    mesh.materials[0].base_color_texture = 0;
    mesh.textures.push_back(checkers(256, 256, {255, 255, 255, 255}, {0, 0, 0, 255}));
    test::add_quad(mesh, {0, 0, 0}, {8, 0, 0}, {8, 0, 8}, {0, 0, 8});
    const VoxelisedMesh coarse = voxelise(mesh, {.voxel_size_m = 0.5});  // 16 texels to a voxel
    for (const PackedRgb packed : coarse.tree.colors().albedo.voxels) {
        EXPECT_NEAR(unpack_rgb(packed).g, 0.25f, 0.01f);
    }
    const VoxelisedMesh fine = voxelise(mesh, {.voxel_size_m = 1.0 / 128.0});  // a quarter texel
    size_t extreme = 0;
    for (const PackedRgb packed : fine.tree.colors().albedo.voxels) {
        const float g = unpack_rgb(packed).g;
        extreme += g < 0.1f || g > 0.4f ? 1 : 0;
    }
    EXPECT_GT(extreme, fine.report.voxels / 20);
    EXPECT_NEAR(mean_albedo(fine.tree).g, 0.25f, 0.01f);
}

TEST(VoxelLook, CutOutsKeepTheirHolesAndLoseNoLeaf) {
    TriangleMesh mesh;
    test::add_material(mesh, Rgb(1.0f));
    mesh.materials[0].base_color_texture = 0;
    mesh.materials[0].alpha_cutoff = 0.5f;
    // The left half is a hole, but for one texel.
    Texture texture{.width_px = 64, .height_px = 64, .texels = {}};
    for (int i = 0; i < 64 * 64; ++i) {
        const bool there = i % 64 >= 32 || i == 64 * 20 + 10;
        texture.texels.push_back({0, 200, 0, static_cast<uint8_t>(there ? 255 : 0)});
    }
    mesh.textures.push_back(texture);
    test::add_quad(mesh, {0, 0, 0}, {8, 0, 0}, {8, 0, 8}, {0, 0, 8});
    for (const double size_m : {0.05, 0.4}) {
        const VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = size_m});
        EXPECT_EQ(made.report.uncovered_points, 0u);
        uint64_t left = 0;
        made.tree.for_each_voxel([&](const IVec3& p) {
            const double x = (p.x + 0.5) * size_m + made.corner_m.x;
            const double z = (p.z + 0.5) * size_m + made.corner_m.z;
            if (x < 4.0 - size_m) {
                ++left;
                EXPECT_NEAR(x, 10.5 * 0.125, size_m + 0.07);
                EXPECT_NEAR(z, 20.5 * 0.125, size_m + 0.07);
            }
        });
        EXPECT_GE(left, 1u);
        for (const PackedRgb packed : made.tree.colors().albedo.voxels) {
            EXPECT_NEAR(unpack_rgb(packed).g, 0.5776f, 0.01f);  // 200 of sRGB, undiluted
        }
    }
}

/// Power that leaves through the top of all voxels, over what the lamp sends that way.
double power_ratio(double lamp_m, const glm::dmat3& turned) {
    TriangleMesh mesh;
    const uint32_t lamp = test::add_material(mesh, Rgb(0.0f), Rgb(100.0f));
    const Vec3 u = turned * Vec3(0.5 * lamp_m, 0, 0);
    const Vec3 v = turned * Vec3(0, 0, -0.5 * lamp_m);
    const Vec3 at(0.21, 0.1, 0.33);
    test::add_quad(mesh, at - u - v, at + u - v, at + u + v, at - u + v, lamp);
    const VoxelisedMesh made = voxelise(mesh, {.voxel_size_m = 1.0, .corner_m = Vec3(-32.0)});
    const ColorLevels& emission = made.tree.colors().emission;
    double sum = 0.0;
    uint32_t index = 0;
    made.tree.for_each_voxel([&](const IVec3& p) {
        const Rgb value = unpack_rgb(emission.voxels[index++]) * emission.scale;
        if (!made.tree.occupied(p + IVec3(0, 1, 0))) sum += value.r;
    });
    return sum / (100.0 * lamp_m * lamp_m * std::abs((turned * Vec3(0, 1, 0)).y));
}

TEST(VoxelLook, LampsKeepTheirPowerHoweverSmall) {
    for (const double lamp_m : {0.01, 0.1, 0.5}) {
        const double ratio = power_ratio(lamp_m, glm::dmat3(1.0));
        EXPECT_GE(ratio, 0.99) << lamp_m;
        EXPECT_LE(ratio, 1.9) << lamp_m;
    }
    // Large ones grow by the voxels on their edge, and all of them keep their radiance.
    EXPECT_NEAR(power_ratio(20.0, glm::dmat3(1.0)), 1.05, 0.08);
    RandomStream random(5);
    for (int i = 0; i < 5; ++i) {
        glm::dmat3 turned = test::random_rotation(random);
        while (std::abs((turned * Vec3(0, 1, 0)).y) < 0.6) turned = test::random_rotation(random);
        EXPECT_NEAR(power_ratio(20.0, turned), 1.1, 0.15);
    }
}

}  // namespace
}  // namespace probebake
