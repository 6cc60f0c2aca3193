#include "bake/sh_audit.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace probebake {
namespace {

constexpr size_t kChannels = 3;
constexpr size_t kDimensions = kShCount * kChannels;
/// Lengths of the coefficients of a radiance of 1, if they were all of one direction: 4π √(9 / 4π),
/// and those of irradiance (kShLargestIrradiance).
const double kLongest = 6.0 * std::sqrt(std::numbers::pi);
const double kLongestIrradiance = 4.0 * std::numbers::pi * kShLargestIrradiance;

/// The factor of every coefficient, for the channels that count.
template <class Factor>
std::array<double, kDimensions> factors_of(const Factor& factor) {
    std::array<double, kDimensions> factors{};
    for (size_t i = 0; i < kDimensions; ++i) factors[i] = factor(i / kChannels, i % kChannels);
    return factors;
}

}  // namespace

ShAudit audit_sh(std::span<const ShDraw> draws, int face_size_px, const Unseen& unseen) {
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
    // In one of them, if it is all of one.
    const double all_channels = std::sqrt(double{kChannels}) * unseen.radiance;
    for (size_t channel = 0; channel < kChannels; ++channel) {
        audit.channels[channel] =
            mean.norm(factors_of([&](size_t, size_t c) { return c == channel ? 1.0 : 0.0; }));
        audit.channels[channel].longest = kLongest * all_channels;
        audit.channels[channel].told = unseen.told;
    }
    audit.irradiance.longest = kLongestIrradiance * all_channels;
    audit.irradiance.told = unseen.told;
    return audit;
}

NormEstimate relative_irradiance(const ShAudit& audit, const ShRgb& radiance) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const double norm = irradiance_norm(radiance);
    if (norm > 0.0) return audit.irradiance.scaled(1.0 / norm);
    NormEstimate unbounded = audit.irradiance;
    if (!unbounded.nothing_found()) unbounded.squared = kInfinity;
    if (unbounded.longest > 0.0) unbounded.longest = kInfinity;
    return unbounded;
}

}  // namespace probebake
