#include "bake/audit_size.h"

#include <algorithm>
#include <cmath>

#include "bake/learn.h"
#include "image/cubemap.h"
#include "image/ssim.h"
#include "math/random.h"

namespace probebake {
namespace {

constexpr int kLeastPixels = 12;
constexpr int kLeastPixelsOfMany = 4;
/// Of few probes together, which have nothing else to tell them.
constexpr size_t kFewProbes = 8;
constexpr size_t kLeastPixelsOfFew = 128;
constexpr int kLeastIrradianceDraws = 64;
constexpr int kLeastIrradianceDrawsOfMany = 8;
constexpr int kMostIrradianceDraws = 65'536;
constexpr uint64_t kFewestPixelsOnTheirOwn = 64;
constexpr int kLeastWindows = 16;
constexpr int kLeastWindowsOfMany = 2;
/// Side of a window's grid over the root of a pixel's rays.
constexpr double kWindowTruthPerRay = 0.6;
constexpr int kWindowPixels = kSsimWindow_px * kSsimWindow_px;

int texels(int face_size_px) { return 6 * face_size_px * face_size_px; }

}  // namespace

DrawBounds pixel_draws(const JobSpec& job, int face_size_px) {
    int least = kLeastPixels;
    if (learns(job)) {
        least = kLeastPixelsOfMany;
    } else if (job.probes.size() < kFewProbes) {
        least = static_cast<int>(kLeastPixelsOfFew / job.probes.size());
    }
    return {least, std::max(least, texels(face_size_px))};
}

DrawBounds irradiance_draws(const JobSpec& job, int face_size_px) {
    const int all = std::min(texels(face_size_px), kMostIrradianceDraws);
    const int least = std::max(learns(job) ? kLeastIrradianceDrawsOfMany : kLeastIrradianceDraws,
                               std::min(texels(face_size_px) / 100, all));
    return {least, std::max(least, all)};
}

bool irradiance_is_pooled(const JobSpec& job, int face_size_px) {
    return wants_leaf_rays_only(job) && learns(job) &&
           owned_pixel_count(face_size_px) < kFewestPixelsOnTheirOwn;
}

WindowDraws ssim_windows(const WindowParams& params, double rays) {
    const int as_noisy =
        static_cast<int>(std::ceil(kWindowTruthPerRay * std::sqrt(params.rays_per_pixel)));
    const int grid = std::clamp(as_noisy, params.least_grid, params.truth_grid);
    const double paid_for = rays / (2.0 * grid * grid * kWindowPixels);
    if (!params.pooled || params.teaches) {
        const int least = params.of_many ? kLeastWindowsOfMany : kLeastWindows;
        return {std::max(least, static_cast<int>(paid_for)), grid};
    }
    return {in_pairs(paid_for, params.lot), grid};
}

double audit_lot(uint64_t key, size_t probe) {
    constexpr double kGoldenRatio = 0.6180339887498949;
    const double lot = RandomStream(key).uniform() + kGoldenRatio * static_cast<double>(probe);
    return lot - std::floor(lot);
}

int in_pairs(double draws, double lot) { return 2 * static_cast<int>(draws / 2.0 + lot); }

}  // namespace probebake
