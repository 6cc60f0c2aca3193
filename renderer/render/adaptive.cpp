#include "render/adaptive.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace probebake {

double luminance_variation(std::span<const OneRayPixel> pixels, int width_px, int height_px, int x,
                           int y, MissesInKernel misses) {
    std::array<double, 9> values{};
    int count = 0;
    for (int j = std::max(0, y - 1); j <= std::min(height_px - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(width_px - 1, x + 1); ++i) {
            const OneRayPixel& pixel =
                pixels[static_cast<size_t>(j) * static_cast<size_t>(width_px) +
                       static_cast<size_t>(i)];
            if (!pixel.rendered) continue;
            if (!pixel.hit && misses == MissesInKernel::kLeftOut) continue;
            values[static_cast<size_t>(count++)] = pixel.hit ? pixel.luminance : 0.0;
        }
    }
    if (count == 0) return 0.0;
    double mean = 0.0;
    for (int i = 0; i < count; ++i) mean += values[static_cast<size_t>(i)];
    mean /= count;
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
        const double difference = values[static_cast<size_t>(i)] - mean;
        sum += difference * difference;
    }
    return sum;
}

int adaptive_grid(double variation, double normaliser) {
    const double normalised = variation / normaliser;
    if (normalised >= kAdaptiveFourByFour) return 4;
    if (normalised >= kAdaptiveTwoByTwo) return 2;
    return 0;
}

uint64_t adaptive_rays(std::span<const double> variations, double normaliser) {
    uint64_t rays = variations.size();
    for (const double variation : variations) {
        const int grid = adaptive_grid(variation, normaliser);
        rays += static_cast<uint64_t>(grid * grid);
    }
    return rays;
}

double solve_normaliser(std::vector<double> variations, uint64_t rays) {
    // The cost falls as the normaliser grows, in steps at variation / 0.25 and variation / 0.75.
    std::vector<double> candidates{std::numeric_limits<double>::infinity()};
    for (const double variation : variations) {
        if (!(variation > 0.0)) continue;
        for (const double share : {kAdaptiveTwoByTwo, kAdaptiveFourByFour}) {
            candidates.push_back(std::nextafter(variation / share, candidates.front()));
        }
    }
    std::sort(candidates.begin(), candidates.end());
    const auto affordable =
        std::partition_point(candidates.begin(), candidates.end(),
                             [&](double n) { return adaptive_rays(variations, n) > rays; });
    return affordable == candidates.end() ? candidates.back() : *affordable;
}

}  // namespace probebake
