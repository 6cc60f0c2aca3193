#include "bake/audit.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "bake/audit_size.h"
#include "bake/probe_view.h"
#include "image/ssim.h"

namespace probebake {
namespace {

constexpr double kUniformShare = 0.5;
/// Side of a truth's grid over the root of a pixel's rays, and its least.
constexpr double kTruthPerRay = 1.1;
constexpr int kLeastTruthGrid = 2;
/// Where the truth divides the error, too, its noise biases.
constexpr int kLeastRelativeGrid = 8;
/// Relative standard deviation of a pixel's squared error about what is predicted.
constexpr double kPixelSpread = 2.5;
/// At 95 % no more than 0.0003 of what so many rays all saw black is not.
constexpr uint64_t kRaysThatShowBlack = 10'000;

/// Largest squared difference of luminance to the four neighbours on the face.
double contrast(const Cubemap& cube, const CubePixel& p) {
    const int n = cube.face_size();
    const double here = luminance(cube.at(p));
    double largest = 0.0;
    const auto compare = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= n || y >= n) return;
        largest = std::max(largest, std::abs(luminance(cube.at({p.face, x, y})) - here));
    };
    compare(p.x - 1, p.y);
    compare(p.x + 1, p.y);
    compare(p.x, p.y - 1);
    compare(p.x, p.y + 1);
    return largest * largest;
}

/// Predicted squared error of a stored pixel.
double predicted(const AuditSpec& spec, size_t i, const CubePixel& pixel) {
    const PixelAux& aux = spec.aux[i];
    return aux.predicted_error > 0.0f ? aux.predicted_error
                                      : contrast(spec.as_written, pixel) / aux.samples;
}

/// Rays per side of one estimate of a pixel's truth.
int truth_grid(const AuditSpec& spec, size_t i) {
    if (spec.truth_grid) return *spec.truth_grid;
    const int least = spec.rel_mse ? kLeastRelativeGrid : kLeastTruthGrid;
    const double rays = static_cast<double>(spec.aux[i].samples);
    return std::clamp(static_cast<int>(std::ceil(kTruthPerRay * std::sqrt(rays))), least,
                      spec.largest_truth_grid);
}

/// Rays that one audit of a pixel casts.
double rays_of(const AuditSpec& spec, size_t i) {
    if (spec.reference_rays) return 16.0;
    const int grid = truth_grid(spec, i);
    return 2.0 * grid * grid;
}

/// To the sum 1; empty where all are 0.
void normalise(std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    if (!(sum > 0.0)) return values.clear();
    for (double& value : values) value /= sum;
}

/// Probability of every stored pixel to be drawn.
std::vector<double> draw_probabilities(const AuditSpec& spec) {
    const int n = spec.as_written.face_size();
    const Weighting weighting = spec.drawn_for_sh ? Weighting::kSolidAngle : spec.weighting;
    std::vector<double> without(spec.aux.size());
    std::vector<double> expected(spec.aux.size());
    std::vector<double> hidden(spec.hidden.size());
    for (size_t i = 0; i < without.size(); ++i) {
        const CubePixel pixel = pixel_at(i, n);
        const auto by = [&](double error) {
            return without[i] * pixel_weight(weighting, pixel, n) *
                   (spec.drawn_for_sh ? std::sqrt(error) : error);
        };
        without[i] = 1.0 / std::sqrt(rays_of(spec, i));
        expected[i] = by(predicted(spec, i, pixel));
        if (!hidden.empty()) hidden[i] = by(spec.hidden[i]);
    }
    normalise(without);
    normalise(expected);
    normalise(hidden);
    const double kinds = (expected.empty() ? 0.0 : 1.0) + (hidden.empty() ? 0.0 : 1.0);
    if (kinds == 0.0) return without;
    std::vector<double> probability = without;
    for (size_t i = 0; i < probability.size(); ++i) {
        const double seen =
            (expected.empty() ? 0.0 : expected[i]) + (hidden.empty() ? 0.0 : hidden[i]);
        probability[i] = kUniformShare * without[i] + (1.0 - kUniformShare) * seen / kinds;
    }
    return probability;
}

struct Draws {
    int count = 0;
    bool by_lot = false;
};

Draws number_of_draws(const AuditSpec& spec, const std::vector<double>& probability) {
    if (spec.pixels) return {*spec.pixels};
    double rays_per_draw = 0.0;
    for (size_t i = 0; i < probability.size(); ++i) {
        rays_per_draw += probability[i] * rays_of(spec, i);
    }
    const double paid_for =
        std::min(spec.rays / rays_per_draw, static_cast<double>(spec.most_pixels));
    if (spec.lot && paid_for < spec.least_pixels) return {in_pairs(paid_for, *spec.lot), true};
    return {static_cast<int>(std::clamp(paid_for, static_cast<double>(spec.least_pixels),
                                        static_cast<double>(spec.most_pixels)))};
}

class AuditRun {
  public:
    AuditRun(const AuditSpec& spec, const CancelToken& cancel)
        : spec_(spec), cancel_(cancel), n_(spec.as_written.face_size()) {}

    Audit run() {
        audit_pixels();
        audit_.ssim_lost = spec_.ssim_lost;
        if (spec_.windows > 0) audit_windows();
        return audit_;
    }

  private:
    RandomStream choice_stream(uint64_t part) const {
        return RandomStream(
            random_key({spec_.key, static_cast<uint64_t>(StreamPurpose::kAuditChoice), part}));
    }
    TruthPair truth_of(const CubePixel& stored, uint64_t part, int grid, CostStats& stats) const {
        const uint64_t key =
            random_key({spec_.key, static_cast<uint64_t>(StreamPurpose::kAuditTruth), part});
        return spec_.truth(owner_of(stored, n_), grid, key, stats);
    }

    /// Calls measure(i, stats) for i < count in parallel; adds up the costs in order.
    template <class Measure>
    void for_each(size_t count, Measure measure) {
        std::vector<CostStats> stats(count);
        tbb::parallel_for(size_t{0}, count, [&](size_t i) {
            if (cancel_.cancelled()) return;
            const auto start = std::chrono::steady_clock::now();
            measure(i, stats[i]);
            stats[i].seconds =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        });
        cancel_.throw_if_cancelled();
        for (const CostStats& part : stats) audit_.cost += part;
    }

    void audit_pixels() {
        const std::vector<double> probability = draw_probabilities(spec_);
        const Draws draws = number_of_draws(spec_, probability);
        audit_.by_lot = draws.by_lot;
        std::vector<double> cumulative(probability.size());
        double sum = 0.0;
        for (size_t i = 0; i < probability.size(); ++i) cumulative[i] = sum += probability[i];
        RandomStream random = choice_stream(0);
        std::vector<size_t> drawn;
        for (int i = 0; i < draws.count; ++i) {
            const auto at =
                std::upper_bound(cumulative.begin(), cumulative.end(), random.uniform() * sum);
            drawn.push_back(
                std::min(static_cast<size_t>(at - cumulative.begin()), cumulative.size() - 1));
        }
        std::vector<double> errors(drawn.size());
        std::vector<TruthPair> truths(drawn.size());
        std::vector<double> weights(drawn.size());
        std::vector<ShDraw> differences(spec_.sh ? drawn.size() : 0);
        std::vector<double> irradiance(spec_.noise ? drawn.size() : 0);
        for_each(drawn.size(), [&](size_t i, CostStats& stats) {
            const CubePixel pixel = pixel_at(drawn[i], n_);
            const Rgb& value = spec_.as_written.at(pixel);
            const TruthPair truth = truths[i] =
                truth_of(pixel, i, truth_grid(spec_, drawn[i]), stats);
            const double error = squared_error(value, truth, spec_.exposure);
            const double inverse =
                1.0 / (static_cast<double>(probability.size()) * probability[drawn[i]]);
            weights[i] = pixel_weight(spec_.weighting, pixel, n_) * inverse;
            errors[i] = weights[i] * error;
            if (!spec_.sh) return;
            if (spec_.noise) {
                irradiance[i] = irradiance_weight(pixel, n_) * 3.0 * spec_.exposure *
                                spec_.exposure * error / probability[drawn[i]];
            }
            const Vec3 mean = (Vec3(truth.r1) + Vec3(truth.r2)) / 2.0;
            differences[i] = {pixel, (Vec3(value) - mean) / probability[drawn[i]]};
        });
        audit_.error.mse = mean_of(errors);
        audit_.pixels = drawn.size();
        audit_.error.mse.told = rays_told();
        audit_.error.mse.largest = std::pow(spec_.largest_radiance / spec_.exposure, 2);
        if (spec_.rel_mse) audit_.error.rel_mse = relative_error(drawn, truths, weights);
        predict();
        if (!spec_.sh) return;
        const ShRgb written = project_sh(spec_.as_written);
        if (differences.size() > 1) {
            audit_.sh = audit_sh(differences, n_, unseen(draws, written));
            audit_.error.irradiance = relative_irradiance(*audit_.sh, written);
        }
        const double norm = irradiance_norm(written);
        if (!spec_.noise || norm == 0.0) return;
        audit_.noise = spec_.noise;
        for (double& square : irradiance) square /= norm * norm;
        audit_.error.irradiance_square = mean_of(irradiance);
    }

    Estimate relative_error(const std::vector<size_t>& drawn, const std::vector<TruthPair>& truths,
                            const std::vector<double>& weights) const {
        double mean = mean_value();  // and from that of the file to that of the truth
        for (size_t i = 0; i < drawn.size(); ++i) {
            const Vec3 r = (Vec3(truths[i].r1) + Vec3(truths[i].r2)) / 2.0;
            const Vec3 missing = r - Vec3(spec_.as_written.at(pixel_at(drawn[i], n_)));
            mean += weights[i] * (missing.r + missing.g + missing.b) /
                    (3.0 * spec_.exposure * static_cast<double>(drawn.size()));
        }
        const double floor = relative_floor(mean);
        const auto bounded = [&](Estimate estimate) {
            estimate.told = audit_.error.mse.told;
            estimate.largest = floor > 0.0 ? audit_.error.mse.largest / floor : 0.0;
            return estimate;
        };
        std::vector<double> errors(drawn.size());
        for (size_t i = 0; i < drawn.size(); ++i) {
            const Rgb& value = spec_.as_written.at(pixel_at(drawn[i], n_));
            errors[i] =
                weights[i] * relative_squared_error(value, truths[i], spec_.exposure, floor);
        }
        return bounded(mean_of(errors));
    }

    /// Of irradiance, where only a lot's few draws, or few rays of a file that is black, found
    /// nothing. Among black surroundings of bright lamps more of them prove nothing of any use by
    /// such a bound, though most of those files are right (docs/decisions.md).
    Unseen unseen(const Draws& draws, const ShRgb& written) const {
        const uint64_t told = audit_.error.mse.told;
        const bool lit = std::any_of(spec_.hidden.begin(), spec_.hidden.end(),
                                     [](double found) { return found > 0.0; });
        const bool doubtful = irradiance_norm(written) == 0.0 && (lit || told < kRaysThatShowBlack);
        if (!draws.by_lot && !doubtful) return {};
        return {spec_.largest_radiance, told};
    }

    /// Rays of render and audit: had they met something that differs, they would have shown it.
    uint64_t rays_told() const {
        double rays = static_cast<double>(audit_.cost.all_rays());
        for (size_t i = 0; i < spec_.aux.size(); ++i) {
            const CubePixel pixel = pixel_at(i, n_);
            if (owner_of(pixel, n_) == pixel) rays += static_cast<double>(spec_.aux[i].samples);
        }
        return static_cast<uint64_t>(rays);
    }

    static Estimate mean_of(const std::vector<double>& values) {
        Moments moments;
        for (const double value : values) moments.add(value);
        return Estimate::of_mean(moments);
    }

    void predict() {
        std::vector<double> owned(spec_.aux.size());
        double sum = 0.0;
        for (size_t i = 0; i < spec_.aux.size(); ++i) {
            const CubePixel pixel = pixel_at(i, n_);
            const double error = pixel_weight(spec_.weighting, pixel, n_) *
                                 static_cast<double>(spec_.aux[i].predicted_error);
            sum += error;
            owned[cube_index(owner_of(pixel, n_), n_)] += error;
        }
        if (!(sum > 0.0)) return;
        const double squares = std::inner_product(owned.begin(), owned.end(), owned.begin(), 0.0);
        audit_.predicted =
            sum / static_cast<double>(spec_.aux.size()) / (spec_.exposure * spec_.exposure);
        audit_.chance = kPixelSpread * std::sqrt(squares) / sum;
    }

    /// Of the file, over pixels and channels.
    double mean_value() const {
        double sum = 0.0;
        for (size_t i = 0; i < spec_.aux.size(); ++i) {
            const CubePixel pixel = pixel_at(i, n_);
            const Rgb& value = spec_.as_written.at(pixel);
            sum += pixel_weight(spec_.weighting, pixel, n_) *
                   (static_cast<double>(value.r) + value.g + value.b) / 3.0;
        }
        return sum / static_cast<double>(spec_.aux.size()) / spec_.exposure;
    }

    void audit_windows() {
        RandomStream random = choice_stream(1);
        std::vector<CubePixel> corners;
        const auto range = static_cast<uint64_t>(n_ - kSsimWindow_px + 1);
        for (int i = 0; i < spec_.windows; ++i) {
            const CubeFace face = kCubeFaces[random.below(kFaceCount)];
            const int x = static_cast<int>(random.below(range));
            corners.push_back({face, x, static_cast<int>(random.below(range))});
        }
        std::vector<double> values(corners.size());
        for_each(corners.size(), [&](size_t i, CostStats& stats) {
            values[i] = window_ssim(corners[i], audit_.pixels + i, stats);
        });
        audit_.error.ssim = mean_of(values);
        audit_.windows = corners.size();
    }

    double window_ssim(const CubePixel& corner, uint64_t part, CostStats& stats) const {
        SsimWindow a;
        SsimWindow r1;
        SsimWindow r2;
        for (int i = 0; i < kSsimWindow_px * kSsimWindow_px; ++i) {
            const CubePixel pixel{corner.face, corner.x + i % kSsimWindow_px,
                                  corner.y + i / kSsimWindow_px};
            const TruthPair truth = truth_of(pixel, random_key({part, static_cast<uint64_t>(i)}),
                                             spec_.window_grid, stats);
            const auto at = static_cast<size_t>(i);
            a[at] = ssim_luminance(spec_.as_written.at(pixel), spec_.exposure);
            r1[at] = ssim_luminance(truth.r1, spec_.exposure);
            r2[at] = ssim_luminance(truth.r2, spec_.exposure);
        }
        return ssim(a, r1, r2);
    }

    const AuditSpec& spec_;
    const CancelToken& cancel_;
    int n_;
    Audit audit_;
};

}  // namespace

TruthOf voxel_truth(const RenderScene& scene, const Vec3& origin, int n, Against against) {
    return [&scene, origin, n, against](const CubePixel& owner, int grid, uint64_t key,
                                        CostStats& stats) {
        return truth_pair(scene, cube_face_view(owner.face, n, origin), owner.x, owner.y,
                          {.against = against, .grid = grid, .key = key}, stats);
    };
}

std::optional<AuditedRatio> audited_ratio(QualityTarget::Metric metric, const Audit& audit) {
    const std::optional<Estimate> size = error_size(metric, audit.error);
    const bool irradiance = metric == QualityTarget::Metric::kIrradianceRel;
    const bool ssim = metric == QualityTarget::Metric::kSsim;
    double predicted = audit.predicted;
    if (irradiance) predicted = audit.noise ? audit.noise->square : 0.0;
    if (ssim && audit.ssim_lost) predicted = *audit.ssim_lost;
    if (!(predicted > 0.0)) return std::nullopt;
    if (!size && !ssim) return std::nullopt;
    const double chance = irradiance ? audit.noise->spread : audit.chance;
    if (!size || size->samples == 0) return AuditedRatio{.predicted = predicted, .chance = chance};
    return AuditedRatio{.predicted = predicted,
                        .measured = size->value,
                        .variance = size->variance,
                        .draws = size->samples,
                        .chance = chance};
}

Audit audit_cubemap(const AuditSpec& spec, const CancelToken& cancel) {
    return AuditRun(spec, cancel).run();
}

}  // namespace probebake
