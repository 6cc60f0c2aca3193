#include "bake/audit_size.h"

#include <algorithm>
#include <cmath>

#include "bake/learn.h"
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
constexpr double kMaxIrradianceDraws = 65'536.0;
constexpr int kLeastWindows = 16;
constexpr int kLeastWindowsOfMany = 2;
/// Side of a window's grid over the root of a pixel's rays.
constexpr double kWindowTruthPerRay = 0.6;
constexpr uint64_t kPairsStream = 17;
constexpr int kWindowPixels = kSsimWindow_px * kSsimWindow_px;

}  // namespace

int irradiance_draws(const JobSpec& job, int truth_grid, int face_size_px, double rays) {
    if (job.quality.evidence.pixels_per_probe) return *job.quality.evidence.pixels_per_probe;
    const double paid_for = rays / (2.0 * truth_grid * truth_grid);
    const double texels = 6.0 * face_size_px * face_size_px;
    const double most = std::min(texels, kMaxIrradianceDraws);
    const double least = std::min(texels / 100.0, most);
    return std::max(learns(job) ? kLeastIrradianceDrawsOfMany : kLeastIrradianceDraws,
                    static_cast<int>(std::clamp(paid_for, least, most)));
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
    return {in_pairs(paid_for, params.key), grid};
}

int in_pairs(double draws, uint64_t key) {
    RandomStream random(random_key({key, kPairsStream}));
    return 2 * static_cast<int>(draws / 2.0 + random.uniform());
}

int least_pixels(const JobSpec& job) {
    if (learns(job)) return kLeastPixelsOfMany;
    if (job.probes.size() >= kFewProbes) return kLeastPixels;
    return static_cast<int>(kLeastPixelsOfFew / job.probes.size());
}

}  // namespace probebake
