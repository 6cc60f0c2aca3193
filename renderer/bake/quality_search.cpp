#include "bake/quality_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "image/ssim.h"
#include "render/adaptive.h"

namespace probebake {
namespace {

constexpr size_t kWindowPixels = size_t{kSsimWindow_px} * kSsimWindow_px;
constexpr int kThresholds = 24;

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

/// Pixels of a window are alike: the window, not the pixel, is what was drawn independently.
Estimate mean_squared_error(const SearchSample& sample, const std::vector<Rgb>& colors) {
    const size_t group = sample.windows ? kWindowPixels : 1;
    Moments moments;
    for (size_t begin = 0; begin < sample.pixels.size(); begin += group) {
        double sum = 0.0;
        for (size_t i = begin; i < begin + group; ++i) {
            const SearchPixel& pixel = sample.pixels[i];
            sum += pixel.weight * squared_error(colors[i], pixel.truth, sample.exposure);
        }
        moments.add(sum / static_cast<double>(group));
    }
    return Estimate::of_mean(moments);
}

}  // namespace

RefinementRecord::Rays replay(const SearchPixel& pixel, const RenderSettings& settings) {
    switch (settings.kind) {
        case RendererKind::kReference: return replay_reference(pixel.record, settings.leaf_grid);
        case RendererKind::kLod: return pixel.record.first;
        case RendererKind::kErrorAware:
            return replay(pixel.record, settings.threshold, settings.leaf_grid);
        case RendererKind::kAdaptive: break;
    }
    const int grid = adaptive_grid(pixel.variation, settings.normaliser);
    if (grid == 0) return pixel.record.first;
    RefinementRecord::Rays total =
        grid == 2 ? pixel.two_by_two : replay_reference(pixel.record, 4);
    total.rays += pixel.record.first.rays;
    total.steps += pixel.record.first.steps;
    return total;
}

MeasuredError measure(const SearchSample& sample, const std::vector<Rgb>& colors) {
    MeasuredError error{mean_squared_error(sample, colors), std::nullopt};
    if (sample.windows) error.ssim = mean_ssim(sample, colors);
    return error;
}

Candidate evaluate(const SearchSample& sample, const RenderSettings& settings) {
    std::vector<Rgb> colors;
    uint64_t rays = 0;
    uint64_t steps = 0;
    for (const SearchPixel& pixel : sample.pixels) {
        const RefinementRecord::Rays replayed = replay(pixel, settings);
        colors.emplace_back(replayed.color);
        rays += replayed.rays;
        steps += replayed.steps;
    }
    const auto n = static_cast<double>(sample.pixels.size());
    return {settings, static_cast<double>(rays) / n, static_cast<double>(steps) / n,
            measure(sample, colors)};
}

std::vector<RenderSettings> candidate_settings(const SearchSample& sample,
                                               const std::vector<RendererKind>& renderers,
                                               int max_leaf_grid) {
    std::vector<RenderSettings> all;
    for (const RendererKind kind : renderers) {
        std::vector<double> scores;
        for (const SearchPixel& pixel : sample.pixels) {
            if (kind == RendererKind::kAdaptive) {
                scores.push_back(pixel.variation / kAdaptiveTwoByTwo);
                continue;
            }
            scores.push_back(pixel.record.first_error);
            for (const auto& quadrant : pixel.record.quadrants) scores.push_back(quadrant.error);
        }
        RenderSettings settings{.kind = kind};
        switch (kind) {
            case RendererKind::kLod: all.push_back(settings); break;
            case RendererKind::kReference:
                for (const int grid : kLeafGrids) {
                    settings.leaf_grid = grid;
                    if (grid <= max_leaf_grid) all.push_back(settings);
                }
                break;
            case RendererKind::kAdaptive:
                for (const double normaliser : quantiles(scores, kThresholds)) {
                    // Just above the score: the pixel that set it is not refined.
                    settings.normaliser = std::nextafter(normaliser, 1e300);
                    all.push_back(settings);
                }
                settings.normaliser = std::numeric_limits<double>::min();
                all.push_back(settings);
                break;
            case RendererKind::kErrorAware: {
                std::vector<double> thresholds = quantiles(scores, kThresholds);
                thresholds.push_back(0.0);
                thresholds.push_back(-1.0);
                for (const int grid : kLeafGrids) {
                    settings.leaf_grid = grid;
                    for (const double threshold : thresholds) {
                        settings.threshold = threshold;
                        if (grid <= max_leaf_grid) all.push_back(settings);
                    }
                }
            }
        }
    }
    return all;
}

std::vector<Candidate> frontier(std::vector<Candidate> candidates, const QualityTarget& target) {
    const auto badness = [&](const Candidate& c) {
        return target.metric == QualityTarget::Metric::kSsim ? -c.error.ssim->value
                                                             : c.error.mse.value;
    };
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) {
                         return a.steps_per_pixel < b.steps_per_pixel;
                     });
    std::vector<Candidate> kept;
    for (Candidate& candidate : candidates) {
        if (kept.empty() || badness(candidate) < badness(kept.back())) {
            kept.push_back(std::move(candidate));
        }
    }
    return kept;
}

}  // namespace probebake
