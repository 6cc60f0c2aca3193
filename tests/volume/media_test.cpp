#include "volume/media.h"

#include <cmath>
#include <limits>

#include "support/ray_families.h"
#include "volume/volume_fixture.h"

namespace probebake {
namespace {

GridShape grid_shape(const Affine& map = {}) {
    return {std::make_shared<DensityGrid>(test::noise_grid({-4, -4, -4}, {24, 20, 28}, 1)), map,
            nullptr};
}

Affine turned_and_scaled() {
    const double c = std::cos(0.7);
    const double s = std::sin(0.7);
    Affine map;
    map.linear = glm::dmat3(c, 0, -s, 0, 1, 0, s, 0, c) * 0.25;
    map.offset = {10.0, -3.0, 7.0};
    return map;
}

double by_quadrature(const Medium& medium, const Ray& ray, double end) {
    constexpr int kSteps = 200000;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        sum += medium.density(ray.origin + ray.direction * ((i + 0.5) * end / kSteps));
    }
    return sum * end / kSteps;
}

TEST(Media, ColumnsAreExact) {
    const Media media({
        {.name = "fog",
         .scattering_per_m = Rgb(0.1f),
         .shape = FogShape{.base_m = 2.0, .scale_height_m = 3.0}},
        {.name = "box",
         .scattering_per_m = Rgb(0.1f),
         .shape = HomogeneousShape{Box{{-1, -2, -3}, {4, 5, 6}}}},
        {.name = "cloud", .scattering_per_m = Rgb(0.1f), .shape = grid_shape(turned_and_scaled())},
    });
    RandomStream random(2);
    for (int i = 0; i < 20; ++i) {
        const Vec3 d = i < 3 ? test::random_axis(random) : test::random_direction(random);
        const Ray ray{
            Vec3(10.0, -3.0, 9.0) - d * 6.0 + test::random_direction(random) * random.uniform(), d};
        for (const Medium& medium : media.all()) {
            EXPECT_NEAR(medium.column(ray, {0.0, 14.0}), by_quadrature(medium, ray, 14.0), 2e-4)
                << medium.spec.name;
        }
    }
}

TEST(Media, FogsColumnAboveIsItsScaleHeight) {
    const Media media({{.name = "fog",
                        .absorption_per_m = Rgb(0.5f),
                        .shape = FogShape{.base_m = 0.0, .scale_height_m = 7.0}}});
    EXPECT_NEAR(media.optical_depth({{0, 0, 0}, {0, 1, 0}}, {})[0], 3.5, 1e-12);
    EXPECT_NEAR(media.optical_depth({{0, 7, 0}, {0, 1, 0}}, {})[1], 3.5 * std::exp(-1.0), 1e-12);
    EXPECT_EQ(media.optical_depth({{0, -1, 0}, {1, 0, 0}}, {0.0, 10.0})[2], 5.0);
}

TEST(Media, OverlappingMediaAddUp) {
    const MediumSpec a{.name = "a",
                       .absorption_per_m = Rgb(1, 2, 3),
                       .scattering_per_m = Rgb(4),
                       .emission = Rgb(1, 1, 2),
                       .shape = HomogeneousShape{}};
    const MediumSpec b{.name = "b",
                       .scattering_per_m = Rgb(0.5f, 0, 0),
                       .shape = HomogeneousShape{Box{{0, 0, 0}, {1, 1, 1}}}};
    const Media media({a, b});
    EXPECT_EQ(media.at({0.5, 0.5, 0.5}).extinction(), Spectrum<3>({5.5, 6.0, 7.0}));
    EXPECT_EQ(media.at({1.5, 0.5, 0.5}).extinction(), Spectrum<3>({5.0, 6.0, 7.0}));
    EXPECT_EQ(media.emitted_per_m({0.5, 0.5, 0.5}), Spectrum<3>({1.0, 2.0, 6.0}));
}

TEST(Media, AGridStandsWhereItsMapPutsIt) {
    const GridShape shape = grid_shape(turned_and_scaled());
    const Media media({{.name = "cloud", .scattering_per_m = Rgb(2.0f), .shape = shape}});
    RandomStream random(3);
    for (int i = 0; i < 1000; ++i) {
        const Vec3 index = Vec3(random.uniform(), random.uniform(), random.uniform()) * 30.0 - 5.0;
        const Vec3 world = shape.index_to_world.point(index);
        EXPECT_NEAR(media.at(world).scattering[0], 2.0 * shape.density->sample(index), 1e-9);
        EXPECT_TRUE(shape.density->sample(index) == 0.0 || media.all()[0].box.contains(world));
    }
}

TEST(Media, MediaThatDoNothingAreLeftOut) {
    const Media media({{.name = "nothing", .shape = HomogeneousShape{}}});
    EXPECT_TRUE(media.empty());
}

TEST(Media, WhatCannotBeIsRefusedByName) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    const auto message = [](const MediumSpec& spec) -> std::string {
        try {
            check_medium(spec);
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "";
    };
    const HomogeneousShape all;
    EXPECT_EQ(message({.name = "m", .absorption_per_m = Rgb(0, -1, 0), .shape = all}),
              "medium 'm': absorption_per_m must be finite and not negative");
    EXPECT_EQ(message({.name = "m", .scattering_per_m = Rgb(kNan), .shape = all}),
              "medium 'm': scattering_per_m must be finite and not negative");
    for (const double g : {-1.0, 1.0, std::nan("")}) {
        EXPECT_EQ(message({.name = "m", .scattering_per_m = Rgb(1), .g = g, .shape = all}),
                  "medium 'm': g must lie between -1 and 1, ends excluded");
    }
    EXPECT_NE(message({.name = "m", .scattering_per_m = Rgb(1), .emission = Rgb(1), .shape = all}),
              "");
    EXPECT_NE(message({.name = "m", .shape = FogShape{.scale_height_m = 0.0}}), "");
    EXPECT_NE(message({.name = "m", .shape = HomogeneousShape{Box{{0, 0, 0}, {1, 0, 1}}}}), "");
    EXPECT_NE(message({.name = "m", .shape = GridShape{}}), "");
    GridShape flat = grid_shape();
    flat.index_to_world.linear = glm::dmat3(0.0);
    EXPECT_EQ(message({.name = "m", .shape = flat}),
              "medium 'm': its index-to-world map cannot be inverted");
    EXPECT_THROW(Media(std::vector<MediumSpec>(9, {.scattering_per_m = Rgb(1), .shape = all})),
                 std::length_error);
}

}  // namespace
}  // namespace probebake
