// Cubemaps that the tests of images share.
#pragma once

#include "image/cubemap.h"
#include "math/random.h"

namespace probebake::test {

/// The unit direction of a pixel.
inline Vec3 pixel_direction(const CubePixel& p, int n) {
    return glm::normalize(face_direction(p.face, grid_coordinate(p.x, n), grid_coordinate(p.y, n)));
}

template <class Function>
Cubemap make_cubemap(int n, const Function& radiance) {
    Cubemap cubemap(n);
    for (const CubeFace face : kCubeFaces) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) cubemap.at({face, x, y}) = radiance(CubePixel{face, x, y});
        }
    }
    cubemap.share_edges();
    return cubemap;
}

/// Uniform in [0, largest).
inline Cubemap random_cubemap(int n, uint64_t seed, double largest = 1.0) {
    RandomStream random(seed);
    const auto value = [&] { return static_cast<float>(largest * random.uniform()); };
    return make_cubemap(n, [&](const CubePixel&) {
        const float r = value();
        const float g = value();
        return Rgb(r, g, value());
    });
}

/// 0.5 + 0.5 d: shows where a reader believes a pixel to be.
inline Cubemap direction_cubemap(int n) {
    return make_cubemap(n,
                        [&](const CubePixel& p) { return Rgb(0.5 + 0.5 * pixel_direction(p, n)); });
}

/// Smooth waves and an edge, like a picture: what SSIM is made for.
inline Cubemap wave_cubemap(int n) {
    return make_cubemap(n, [&](const CubePixel& p) {
        const Vec3 d = pixel_direction(p, n);
        const double edge = d.x + d.y > 0.2 ? 0.5 : 0.0;
        return Rgb(Vec3(0.5 + 0.4 * std::sin(9.0 * d.x) * std::cos(7.0 * d.z), 0.3 + edge,
                        0.5 + 0.5 * d.y));
    });
}

/// The cubemap plus noise of the given standard deviation, not below 0.
inline Cubemap with_noise(const Cubemap& cubemap, double deviation, uint64_t seed) {
    RandomStream random(seed);
    Cubemap noisy = cubemap;
    const auto noise = [&] {
        return static_cast<float>((2.0 * random.uniform() - 1.0) * deviation * std::sqrt(3.0));
    };
    for (Rgb& c : noisy.image().pixels()) {
        for (int i = 0; i < 3; ++i) c[i] = std::max(0.0f, c[i] + noise());
    }
    noisy.share_edges();
    return noisy;
}

}  // namespace probebake::test
