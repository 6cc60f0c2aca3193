#include "bake/quality_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "image/ssim.h"
#include "render/adaptive.h"

namespace probebake {
namespace {

constexpr size_t kWindowPixels = size_t{kSsimWindow_px} * kSsimWindow_px;
constexpr int kThresholds = 12;
constexpr int kSpreads = 12;
constexpr int kPrices = 24;

/// `count` quantiles of the positive values, largest first.
std::vector<double> quantiles(std::vector<double> values, int count) {
    values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return !(v > 0.0); }),
                 values.end());
    std::sort(values.begin(), values.end(), std::greater<>());
    std::vector<double> picked;
    for (int i = 0; i < count && !values.empty(); ++i) {
        const double value =
            values[static_cast<size_t>(i) * values.size() / static_cast<size_t>(count)];
        if (picked.empty() || value < picked.back()) picked.push_back(value);
    }
    return picked;
}

Estimate mean_ssim(const SearchSample& sample, const std::vector<Rgb>& colors) {
    Moments moments;
    for (size_t begin = 0; begin < sample.pixels.size(); begin += kWindowPixels) {
        SsimWindow a;
        SsimWindow r1;
        SsimWindow r2;
        for (size_t i = 0; i < kWindowPixels; ++i) {
            const TruthPair& truth = sample.pixels[begin + i].truth;
            a[i] = ssim_luminance(colors[begin + i], sample.exposure);
            r1[i] = ssim_luminance(truth.r1, sample.exposure);
            r2[i] = ssim_luminance(truth.r2, sample.exposure);
        }
        moments.add(ssim(a, r1, r2));
    }
    return Estimate::of_mean(moments);
}

/// Mean of error(color, truth) over the pixels. Pixels of a window are alike: the window, not the
/// pixel, is what was drawn independently.
template <class Error>
Estimate mean_error(const SearchSample& sample, const std::vector<Rgb>& colors, Error error) {
    const size_t group = sample.windows ? kWindowPixels : 1;
    Moments moments;
    for (size_t begin = 0; begin < sample.pixels.size(); begin += group) {
        double sum = 0.0;
        for (size_t i = begin; i < begin + group; ++i) {
            const SearchPixel& pixel = sample.pixels[i];
            sum += pixel.weight * error(colors[i], pixel.truth);
        }
        moments.add(sum / static_cast<double>(group));
    }
    return Estimate::of_mean(moments);
}

}  // namespace

ReplayedPixel replay(const SearchPixel& pixel, const RenderSettings& settings) {
    const RefinementRecord::Rays& first = pixel.record.first;
    switch (settings.kind) {
        case RendererKind::kReference:
            return replay_reference(pixel.record, settings.leaf_grid);
        case RendererKind::kLod:
            return {first.color, first.rays, first.steps};
        case RendererKind::kErrorAware:
            return replay_error_aware(pixel.record, settings);
        case RendererKind::kHybrid:
            return replay_hybrid(pixel.hybrid, settings);
        case RendererKind::kAdaptive:
        case RendererKind::kPaths:  // never replayed
            break;
    }
    const int grid = adaptive_grid(pixel.variation, settings.normaliser);
    if (grid == 0) return {first.color, first.rays, first.steps};
    ReplayedPixel refined = replay_reference(pixel.record, grid);
    refined.rays += first.rays;
    refined.steps += first.steps;
    return refined;
}

MeasuredError measure(const SearchSample& sample, const std::vector<Rgb>& colors) {
    MeasuredError error{mean_error(sample, colors, [&](const Rgb& value, const TruthPair& truth) {
        return squared_error(value, truth, sample.exposure);
    })};
    if (sample.windows) error.ssim = mean_ssim(sample, colors);
    if (!sample.rel_mse) return error;
    double mean = 0.0;
    for (const SearchPixel& pixel : sample.pixels) {
        const Vec3 truth = (Vec3(pixel.truth.r1) + Vec3(pixel.truth.r2)) / 2.0;
        mean += pixel.weight * (truth.x + truth.y + truth.z) / 3.0 / sample.exposure;
    }
    const double floor = relative_floor(mean / static_cast<double>(sample.pixels.size()));
    error.rel_mse = mean_error(sample, colors, [&](const Rgb& value, const TruthPair& truth) {
        return relative_squared_error(value, truth, sample.exposure, floor);
    });
    return error;
}

Candidate evaluate(const SearchSample& sample, const RenderSettings& settings) {
    std::vector<Rgb> colors;
    uint64_t rays = 0;
    uint64_t steps = 0;
    double predicted = 0.0;
    double seconds = 0.0;
    for (const SearchPixel& pixel : sample.pixels) {
        const ReplayedPixel replayed = replay(pixel, settings);
        predicted += pixel.weight * replayed.predicted;
        seconds += replayed.seconds;
        colors.emplace_back(replayed.color);
        rays += replayed.rays;
        steps += replayed.steps;
    }
    const auto n = static_cast<double>(sample.pixels.size());
    return {.settings = settings,
            .rays_per_pixel = static_cast<double>(rays) / n,
            .steps_per_pixel = static_cast<double>(steps) / n,
            .seconds_per_pixel = seconds / n,
            .predicted = predicted / n / (sample.exposure * sample.exposure),
            .error = measure(sample, colors)};
}

namespace {

std::vector<RenderSettings> reference_settings(int max_leaf_grid, bool coarse) {
    std::vector<RenderSettings> all;
    for (const int grid : kCoarseGrids) {
        if (coarse) all.push_back({.kind = RendererKind::kReference, .leaf_grid = grid});
    }
    for (const int grid : kLeafGrids) {
        if (grid <= max_leaf_grid) {
            all.push_back({.kind = RendererKind::kReference, .leaf_grid = grid});
        }
    }
    return all;
}

std::vector<RenderSettings> adaptive_settings(const SearchSample& sample) {
    std::vector<double> scores;
    for (const SearchPixel& pixel : sample.pixels) {
        scores.push_back(pixel.variation / kAdaptiveTwoByTwo);
    }
    std::vector<RenderSettings> all;
    for (const double score : quantiles(scores, kThresholds)) {
        // Just above the score: the pixel that set it is not refined.
        all.push_back({.kind = RendererKind::kAdaptive,
                       .normaliser = std::nextafter(score, std::numeric_limits<double>::max())});
    }
    all.push_back(
        {.kind = RendererKind::kAdaptive, .normaliser = std::numeric_limits<double>::min()});
    return all;
}

std::vector<RenderSettings> error_aware_settings(const SearchSample& sample, int max_leaf_grid) {
    std::vector<double> errors;
    std::vector<double> spreads;
    for (const SearchPixel& pixel : sample.pixels) {
        errors.push_back(pixel.record.first_error);
        for (const auto& quadrant : pixel.record.quadrants) errors.push_back(quadrant.error);
        spreads.push_back(leaf_spread(pixel.record));
    }
    std::vector<double> thresholds = quantiles(errors, kThresholds);
    thresholds.push_back(0.0);
    thresholds.push_back(-1.0);
    std::vector<RenderSettings> all;
    all.reserve(thresholds.size());
    for (const double threshold : thresholds) all.push_back({.threshold = threshold});
    for (const int grid : kLeafGrids) {
        if (grid == 4 || grid > max_leaf_grid) continue;
        for (const double spread : quantiles(spreads, kSpreads)) {
            for (const double threshold : thresholds) {
                all.push_back({.threshold = threshold, .leaf_grid = grid, .spread = spread});
            }
        }
    }
    return all;
}

}  // namespace

std::vector<RenderSettings> candidate_settings(const SearchSample& sample,
                                               const std::vector<RendererKind>& renderers,
                                               int max_leaf_grid) {
    std::vector<RenderSettings> all;
    const auto add = [&](const std::vector<RenderSettings>& some) {
        all.insert(all.end(), some.begin(), some.end());
    };
    for (const RendererKind kind : renderers) {
        switch (kind) {
            case RendererKind::kLod:
                add({{.kind = kind}});
                break;
            case RendererKind::kReference:
                add(reference_settings(max_leaf_grid, renderers.size() > 1));
                break;
            case RendererKind::kAdaptive:
                add(adaptive_settings(sample));
                break;
            case RendererKind::kErrorAware:
                add(error_aware_settings(sample, max_leaf_grid));
                break;
            case RendererKind::kHybrid:
            case RendererKind::kPaths:
                break;
        }
    }
    return all;
}

std::vector<RenderSettings> hybrid_settings(const SearchSample& sample, double lowest) {
    std::vector<double> gains;
    for (const SearchPixel& pixel : sample.pixels) {
        for (int stage = 0; stage < pixel.hybrid.recorded(); ++stage) {
            const double gain = pixel.hybrid.stages[static_cast<size_t>(stage)].gain;
            if (gain > lowest) gains.push_back(gain);
        }
    }
    std::vector<RenderSettings> all;
    for (const double price : quantiles(gains, kPrices)) all.push_back(hybrid_at(price));
    all.push_back(hybrid_at(lowest));
    return all;
}

std::vector<RenderSettings> finest_settings(const std::vector<RendererKind>& renderers) {
    switch (renderers.front()) {
        case RendererKind::kLod:
            return {};
        case RendererKind::kAdaptive:
            return {{.kind = RendererKind::kAdaptive,
                     .normaliser = std::numeric_limits<double>::min()}};
        case RendererKind::kReference:
            return reference_settings(kLeafGrids.back(), false);
        case RendererKind::kHybrid:
        case RendererKind::kPaths:
            return {};
        case RendererKind::kErrorAware:
            break;
    }
    std::vector<RenderSettings> all;
    all.reserve(kLeafGrids.size());
    for (const int grid : kLeafGrids) {
        // Everything to 4 × 4; on from there wherever two rays differ at all.
        all.push_back({.threshold = -1.0, .leaf_grid = grid, .spread = 0.0});
    }
    return all;
}

std::vector<Candidate> frontier(std::vector<Candidate> candidates, const QualitySpec& quality) {
    const auto badness = [&](const Candidate& c) {
        const auto size = error_size(quality.targets.front().metric, c.error);
        return size ? size->value : c.error.mse.value;
    };
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) {
                         return a.steps_per_pixel < b.steps_per_pixel;
                     });
    std::vector<Candidate> kept;
    for (const Candidate& candidate : candidates) {
        if (kept.empty() || badness(candidate) < badness(kept.back())) kept.push_back(candidate);
    }
    return kept;
}

}  // namespace probebake
