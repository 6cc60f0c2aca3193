#include "bake/irradiance_noise.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
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

/// The square of a pixel's solid angle, shared out among those that have its value.
double squared_solid_angle(const CubePixel& pixel, int n) {
    const double solid_angle = pixel_solid_angle(pixel.x, pixel.y, n);
    return solid_angle * solid_angle * copies(pixel, n);
}

}  // namespace

double irradiance_weight(const CubePixel& pixel, int face_size_px) {
    const double basis2 =
        std::inner_product(kShIrradiance.begin(), kShIrradiance.end(), kShIrradiance.begin(), 0.0) /
        (4.0 * std::numbers::pi);
    return basis2 * squared_solid_angle(pixel, face_size_px);
}

IrradianceNoise irradiance_noise(const Cubemap& as_written, std::span<const PixelAux> aux) {
    const int n = as_written.face_size();
    std::array<Sh9, kShCount> covariance{};
    IrradianceNoise noise;
    for (size_t i = 0; i < aux.size(); ++i) {
        const Vec3 error(aux[i].standard_error);
        if (error == Vec3(0.0)) continue;
        const CubePixel pixel = pixel_at(i, n);
        Sh9 basis = sh_basis(pixel, n);
        const double weight = squared_solid_angle(pixel, n);
        noise.channels +=
            error * error * (weight * static_cast<double>(kShCount) / (4.0 * std::numbers::pi));
        for (size_t k = 0; k < kShCount; ++k) basis[k] *= kShIrradiance[k];
        for (size_t k = 0; k < kShCount; ++k) {
            const double scaled = weight * glm::dot(error, error) * basis[k];
            for (size_t l = 0; l < kShCount; ++l) covariance[k][l] += scaled * basis[l];
        }
    }
    double trace = 0.0;
    double trace2 = 0.0;  // of the covariance's square
    for (size_t k = 0; k < kShCount; ++k) {
        trace += covariance[k][k];
        for (const double c : covariance[k]) trace2 += c * c;
    }
    if (trace == 0.0) return noise;
    const double norm = irradiance_norm(project_sh(as_written));
    noise.square = trace / (norm * norm);
    noise.spread = std::sqrt(2.0 * trace2) / trace;
    return noise;
}

IrradianceNorms coarse_irradiance_norms(const std::vector<ProbeSpec>& probes,
                                        const std::vector<NoisyPixel>& sample,
                                        const SeeCoarsely& see) {
    IrradianceNorms norms;
    std::vector<size_t> drawn;
    for (const NoisyPixel& at : sample) {
        if (norms.of_probe.emplace(at.probe, 0.0).second) drawn.push_back(at.probe);
    }
    std::vector<CostStats> costs(drawn.size());
    std::vector<double> squares(drawn.size(), 0.0);
    tbb::parallel_for(size_t{0}, drawn.size(), [&](size_t i) {
        CoarsePixel at{.probe = probes[drawn[i]], .index = drawn[i] << 32U};
        const int n = std::min(kCoarseFace_px, at.probe.face_size_px);
        at.probe.face_size_px = n;
        Cubemap coarse(n);
        for (const CubeFace face : kCubeFaces) {
            for (int y = 0; y < n; ++y) {
                for (int x = 0; x < n; ++x, ++at.index) {
                    at.pixel = {face, x, y};
                    const CoarseColor seen = see(at, costs[i]);
                    coarse.at(at.pixel) = seen.mean;
                    squares[i] += irradiance_weight(at.pixel, n) * seen.variance;
                }
            }
        }
        const double norm = irradiance_norm(project_sh(coarse));
        norms.of_probe.at(drawn[i]) = norm;
        squares[i] *= norm > 0.0 ? static_cast<double>(owned_pixel_count(n)) / (norm * norm) : 0.0;
    });
    for (const double square : squares) {
        norms.square_times_paths += square / static_cast<double>(drawn.size());
    }
    for (const CostStats& cost : costs) norms.cost += cost;
    return norms;
}

std::optional<Estimate> expected_irradiance_square(const std::vector<NoisyPixel>& sample,
                                                   const IrradianceNorms& norms) {
    Moments moments;
    for (const NoisyPixel& at : sample) {
        const double norm = norms.of_probe.at(at.probe);
        if (norm > 0.0) {
            const double pixels = 6.0 * at.face_size_px * at.face_size_px;
            moments.add(pixels * irradiance_weight(at.pixel, at.face_size_px) * at.variance /
                        (norm * norm));
        } else if (at.variance == 0.0) {
            moments.add(0.0);
        } else {
            return std::nullopt;
        }
    }
    return Estimate::of_mean(moments);
}

}  // namespace probebake
