#include "study/octrees/fluid_scene.h"

#include <array>
#include <cmath>

#include "math/random.h"

namespace probebake::study {
namespace {

constexpr int kDrops = 2513;
constexpr double kDropRadius = 0.02;
constexpr double kBallRadius = 0.25;

/// Pushes space out of the ball without compressing it: r³ grows by the ball's radius cubed.
Vec3 around_ball(const Vec3& p) {
    const double r = glm::length(p);
    return p * (std::cbrt(r * r * r + kBallRadius * kBallRadius * kBallRadius) / r);
}

}  // namespace

NffScene fluid_stand_in() {
    NffScene scene;
    scene.view = NffView{.from = {0.6, -3.2, 1.2},
                         .at = {0.0, 0.0, 0.1},
                         .up = {0.0, 0.0, 1.0},
                         .angle_deg = 45.0,
                         .hither = 0.01,
                         .width_px = 512,
                         .height_px = 512};
    scene.lights = {{.position = {2.0, -3.0, 4.0}}, {.position = {-3.0, -2.0, 2.0}}};
    const auto add_material = [&](const Rgb& color, double specular) {
        scene.materials.push_back(
            {.color = color, .diffuse = 1.0 - specular, .specular = specular, .shine = 20.0});
        return static_cast<uint32_t>(scene.materials.size() - 1);
    };
    const auto add_object = [&](uint32_t material) {
        scene.objects.push_back({.material = material});
    };

    scene.shapes.add_polygon(std::array<Vec3, 4>{Vec3(-4.0, 1.5, -2.0), Vec3(4.0, 1.5, -2.0),
                                                 Vec3(4.0, 1.5, 2.0), Vec3(-4.0, 1.5, 2.0)});
    add_object(add_material(Rgb(0.9f), 0.9));
    scene.shapes.add(Sphere{Vec3(0.0), kBallRadius});
    add_object(add_material(Rgb(0.8f, 0.3f, 0.2f), 0.3));
    const uint32_t water = add_material(Rgb(0.2f, 0.4f, 0.8f), 0.3);
    RandomStream random(random_key({0x666C756964}));
    for (int i = 0; i < kDrops; ++i) {
        const Vec3 at(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
        scene.shapes.add(Sphere{around_ball(at * Vec3(1.8, 0.5, 0.9)), kDropRadius});
        add_object(water);
    }
    return scene;
}

}  // namespace probebake::study
