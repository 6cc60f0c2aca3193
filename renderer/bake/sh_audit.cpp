#include "bake/sh_audit.h"

#include <cmath>
#include <limits>

namespace probebake {
namespace {

constexpr size_t kChannels = 3;
constexpr size_t kDimensions = kShCount * kChannels;

/// The factor of every coefficient, for the channels that count.
template <class Factor>
std::array<double, kDimensions> factors_of(const Factor& factor) {
    std::array<double, kDimensions> factors{};
    for (size_t i = 0; i < kDimensions; ++i) factors[i] = factor(i / kChannels, i % kChannels);
    return factors;
}

}  // namespace

ShAudit audit_sh(std::span<const ShDraw> draws, int face_size_px) {
    std::vector<double> samples;
    samples.reserve(draws.size() * kDimensions);
    for (const ShDraw& draw : draws) {
        const Sh9 basis = sh_basis(draw.pixel, face_size_px);
        const double weight = pixel_solid_angle(draw.pixel.x, draw.pixel.y, face_size_px);
        for (const double y : basis) {
            for (int c = 0; c < 3; ++c) samples.push_back(weight * y * draw.difference[c]);
        }
    }
    const VectorMean mean(samples, kDimensions);
    ShAudit audit{.draws = draws.size()};
    for (size_t i = 0; i < kDimensions; ++i) {
        const auto channel = static_cast<int>(i % kChannels);
        audit.difference[i / kChannels][channel] = mean.mean()[i];
        audit.standard_error[i / kChannels][channel] = mean.standard_error(i);
    }
    audit.irradiance = mean.norm(factors_of([](size_t i, size_t) { return kShIrradiance[i]; }));
    for (size_t channel = 0; channel < kChannels; ++channel) {
        audit.channels[channel] =
            mean.norm(factors_of([&](size_t, size_t c) { return c == channel ? 1.0 : 0.0; }));
    }
    return audit;
}

double irradiance_norm(const ShRgb& radiance) {
    double sum = 0.0;
    for (size_t i = 0; i < radiance.size(); ++i) {
        const Vec3 irradiance = kShIrradiance[i] * radiance[i];
        sum += glm::dot(irradiance, irradiance);
    }
    return std::sqrt(sum);
}

NormEstimate relative_irradiance(const ShAudit& audit, const ShRgb& radiance) {
    if (audit.irradiance.nothing_found()) return audit.irradiance;
    const double norm = irradiance_norm(radiance);
    if (norm > 0.0) return audit.irradiance.scaled(1.0 / norm);
    NormEstimate unbounded = audit.irradiance;
    unbounded.squared = std::numeric_limits<double>::infinity();
    return unbounded;
}

}  // namespace probebake
