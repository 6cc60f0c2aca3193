#include "bake/irradiance_noise.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numbers>
#include <numeric>

#include "image/sh_projection.h"

namespace probebake {
namespace {

constexpr int kCoarseFace_px = 8;

/// How many stored pixels have the value of this one.
double copies(const CubePixel& pixel, int n) {
    if (n == 1) return 1.0;
    const bool on_column = pixel.x == 0 || pixel.x == n - 1;
    const bool on_row = pixel.y == 0 || pixel.y == n - 1;
    return 1.0 + (on_column ? 1.0 : 0.0) + (on_row ? 1.0 : 0.0);
}

/// Of a pixel's variance, what it adds to the square of its cubemap's irradiance error, times the
/// number of pixels.
double irradiance_weight(const CubePixel& pixel, int n) {
    const double basis2 =
        std::inner_product(kShIrradiance.begin(), kShIrradiance.end(), kShIrradiance.begin(), 0.0) /
        (4.0 * std::numbers::pi);
    const double solid_angle = pixel_solid_angle(pixel.x, pixel.y, n);
    return 6.0 * n * n * basis2 * solid_angle * solid_angle * copies(pixel, n);
}

}  // namespace

IrradianceNorms coarse_irradiance_norms(const std::vector<ProbeSpec>& probes,
                                        const std::vector<NoisyPixel>& sample,
                                        const SeeCoarsely& see) {
    IrradianceNorms norms;
    std::vector<size_t> drawn;
    for (const NoisyPixel& at : sample) {
        if (norms.of_probe.emplace(at.probe, 0.0).second) drawn.push_back(at.probe);
    }
    std::vector<CostStats> costs(drawn.size());
    tbb::parallel_for(size_t{0}, drawn.size(), [&](size_t i) {
        CoarsePixel at{.probe = probes[drawn[i]], .index = drawn[i] << 32U};
        const int n = std::min(kCoarseFace_px, at.probe.face_size_px);
        at.probe.face_size_px = n;
        Cubemap coarse(n);
        for (const CubeFace face : kCubeFaces) {
            for (int y = 0; y < n; ++y) {
                for (int x = 0; x < n; ++x, ++at.index) {
                    at.pixel = {face, x, y};
                    coarse.at(at.pixel) = see(at, costs[i]);
                }
            }
        }
        norms.of_probe.at(drawn[i]) = irradiance_norm(project_sh(coarse));
    });
    for (const CostStats& cost : costs) norms.cost += cost;
    return norms;
}

std::optional<Estimate> expected_irradiance_square(const std::vector<NoisyPixel>& sample,
                                                   const IrradianceNorms& norms) {
    Moments moments;
    for (const NoisyPixel& at : sample) {
        const double norm = norms.of_probe.at(at.probe);
        if (norm > 0.0) {
            moments.add(irradiance_weight(at.pixel, at.face_size_px) * at.variance / (norm * norm));
        } else if (at.variance == 0.0) {
            moments.add(0.0);
        } else {
            return std::nullopt;
        }
    }
    return Estimate::of_mean(moments);
}

}  // namespace probebake
