#include "bake/media_pilot.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bake/learn.h"
#include "image/exposure.h"

namespace probebake {
namespace {

constexpr uint64_t kMinPixels = 256;
constexpr uint64_t kMaxPixels = 1024;
constexpr uint64_t kTexelsPerPixel = 50;
constexpr int kFirstPaths = 16;  // of each of two means
/// Of the paths that the render is expected to take, what truth and curve may each take; but at
/// least kLeastPaths in every pixel.
constexpr double kShare = 0.03;
constexpr int kLeastPaths = 16;

/// Of actual over predicted loss of SSIM to noise.
constexpr ErrorPrior kSsimPrior{.ratio = 1.0, .spread = 0.5, .draw_cv = 1.0};
/// Paths in every pixel, for irradiance: from, to, and from one number to the next.
constexpr int kLeastIrradiancePaths = 4;
constexpr int kMostIrradiancePaths = 4096;
constexpr double kMorePaths = 1.25;
/// Paths in a pixel of the coarse cubemaps of all probes together, and of one at most.
constexpr size_t kCoarsePaths = 512;
constexpr size_t kMostCoarsePaths = 128;

/// Noise that the render aims at, as a share of what the target allows: audits have intervals,
/// whose far ends are to meet it.
constexpr double kAim = 0.85;
/// From one finer setting to the next: the noise by a factor, so many times.
struct FinerSteps {
    double factor = 1.0;
    int count = 0;
};
constexpr FinerSteps kFiner{0.85, 12};        // where the sample tells
constexpr FinerSteps kFinerForSsim{0.7, 16};  // where every probe's own variances do
constexpr FinerSteps kMuchFiner{0.5, 12};     // where looks alone do
/// Where the target is SSIM or a relative error: noise to begin with, in units of exposure.
constexpr double kUntoldNoise = 0.1;
/// And where probes' variances tell of SSIM.
constexpr double kNoiseForSsim = 0.4;
/// Where the target is a number of rays: no noise is small enough.
constexpr double kNoNoise = 1e-30;

struct Place {
    size_t probe = 0;
    CubePixel owner;
    VolumeView view;
};

/// What is known of a pixel.
struct PlacePaths {
    TruthPair truth;
    double variance = 0.0;  // of a path, mean over the channels

    Vec3 mean() const { return (Vec3(truth.r1) + Vec3(truth.r2)) / 2.0; }
};

class MediaPilot {
  public:
    MediaPilot(const Scene& scene, const JobSpec& job, const ReadyState& state,
               const CancelToken& cancel)
        : scene_(scene), job_(job), state_(state), cancel_(cancel) {}

    Pilot run(const std::optional<TimeBudget>& time) {
        Pilot pilot{.state = state_};
        pilot.media = std::make_shared<const MediaState>(
            scene_, state_, job_, [&](RandomStream& random) { return random_ray(random); });
        tracer_ = &*pilot.media->tracer;
        pilot.search_cost += cost_of(pilot.media->depth.count);
        pilot.search_cost += cost_of(pilot.media->tracker_pilot.count);
        if (pilot.media->emitter_pilot) {
            pilot.search_cost += cost_of(pilot.media->emitter_pilot->count);
        }
        choose_places();
        CostStats first;
        trace_truth(kFirstPaths, first);
        seconds_per_path_ = first.seconds / static_cast<double>(first.rays);
        pilot.search_cost += first;
        pilot.exposure = exposure();
        if (has_target(job_.quality, QualityTarget::Metric::kIrradianceRel)) {
            know_irradiance(pilot);
        }
        steer(pilot);
        aim(pilot, time);
        measure_curve(pilot);
        pilot.pixels = places_.size();
        pilot.wall_seconds = seconds();
        return pilot;
    }

  private:
    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

    uint64_t key(uint64_t purpose, uint64_t part) const {
        return random_key({job_.seed, static_cast<uint64_t>(StreamPurpose::kMediaPilot),
                           stream_of(state_.spec), purpose, part});
    }

    /// Any pixel of any probe, all with the same probability.
    Place random_place(RandomStream& random) const {
        Place place;
        place.probe = random.below(job_.probes.size());
        const ProbeSpec& probe = job_.probes[place.probe];
        const auto n = static_cast<uint64_t>(probe.face_size_px);
        const CubeFace face = kCubeFaces[random.below(kFaceCount)];
        const int x = static_cast<int>(random.below(n));
        const CubePixel pixel{face, x, static_cast<int>(random.below(n))};
        place.owner = owner_of(pixel, probe.face_size_px);
        place.view = volume_view(scene_, probe, 0);
        return place;
    }

    Ray random_ray(RandomStream& random) const {
        const Place place = random_place(random);
        const int n = place.view.face_size_px;
        const double u = grid_coordinate(place.owner.x + random.uniform() - 0.5, n);
        const double v = grid_coordinate(place.owner.y + random.uniform() - 0.5, n);
        return {place.view.origin_m, glm::normalize(face_direction(place.owner.face, u, v))};
    }

    void choose_places() {
        RandomStream random(key(1, 0));
        const uint64_t texels = texel_count(job_) / job_.states.size();
        const uint64_t count =
            std::min(texels, std::clamp(texels / kTexelsPerPixel, kMinPixels, kMaxPixels));
        for (uint64_t i = 0; i < count; ++i) places_.push_back(random_place(random));
        paths_.resize(places_.size());
    }

    template <class Trace>
    CostStats for_each_place(Trace trace) const {
        std::vector<CostStats> stats(places_.size());
        tbb::parallel_for(size_t{0}, places_.size(), [&](size_t i) {
            if (cancel_.cancelled()) return;
            const auto start = std::chrono::steady_clock::now();
            trace(i, stats[i]);
            stats[i].seconds =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        });
        cancel_.throw_if_cancelled();
        CostStats total;
        for (const CostStats& part : stats) total += part;
        return total;
    }

    /// Two means of `paths` paths in every pixel, and the variance of a path.
    void trace_truth(int paths, CostStats& cost) {
        cost += for_each_place([&](size_t i, CostStats& stats) {
            PathCount count;
            std::array<Vec3, 2> sums{Vec3(0.0), Vec3(0.0)};
            Vec3 sum2(0.0);
            for (size_t which = 0; which < 2; ++which) {
                for (int k = 0; k < paths && !cancel_.cancelled(); ++k) {
                    const PixelPath name{key(2 + which, i), static_cast<uint32_t>(k)};
                    const Vec3 radiance =
                        pixel_path(*tracer_, places_[i].view, places_[i].owner, name, count)
                            .radiance;
                    sums[which] += radiance;
                    sum2 += radiance * radiance;
                }
            }
            const double n = paths;
            const Vec3 all = sums[0] + sums[1];
            const Vec3 variance = (sum2 - all * all / (2.0 * n)) / (2.0 * n - 1.0);
            paths_[i].truth = {Rgb(sums[0] / n), Rgb(sums[1] / n)};
            paths_[i].variance = std::max(0.0, (variance.x + variance.y + variance.z) / 3.0);
            stats += cost_of(count);
        });
    }

    double exposure() const {
        if (job_.quality.exposure) return *job_.quality.exposure;
        std::vector<Rgb> colors;
        for (const PlacePaths& paths : paths_) colors.emplace_back(paths.mean());
        return exposure_of(colors);
    }

    /// Mean standard deviation of a path, over the pixels: n ∝ σ leaves (mean σ)² / mean n.
    double mean_sigma() const {
        double sum = 0.0;
        for (const PlacePaths& paths : paths_) sum += std::sqrt(paths.variance);
        return sum / static_cast<double>(paths_.size());
    }
    /// Paths per pixel that leave this noise, as far as a render goes.
    double needed(double noise) const {
        const double ratio = mean_sigma() / noise;
        return std::clamp(ratio * ratio, static_cast<double>(RenderSettings{}.samples),
                          static_cast<double>(kMostPathsPerPixel));
    }

    void aim(Pilot& pilot, const std::optional<TimeBudget>& time) {
        RenderSettings& settings = pilot.settings;
        settings.kind = RendererKind::kPaths;
        if (wants_leaf_rays_only(job_)) return aim_at_irradiance(pilot);
        if (only_target(job_.quality, QualityTarget::Metric::kRays)) {
            settings.noise = kNoNoise * pilot.exposure;
            return;
        }
        const bool told =
            std::all_of(job_.quality.targets.begin(), job_.quality.targets.end(),
                        [&](const QualityTarget& target) { return noise_for(target); });
        const FinerSteps finer =
            told ? kFiner : (pilot.steering.empty() ? kMuchFiner : kFinerForSsim);
        const double untold = pilot.steering.empty() ? kUntoldNoise : kNoiseForSsim;
        settings.noise = first_noise(untold) * pilot.exposure;
        if (const auto paths = affordable(time); paths && needed(settings.noise) > *paths) {
            settings.noise = mean_sigma() / std::sqrt(*paths);
            pilot.expectation = Expectation::kBudgetExhausted;
        }
        const double relative = settings.noise / pilot.exposure;
        pilot.settings_mse = relative * relative;
        FinerSettings next{settings, pilot.settings_mse};
        for (int i = 0; i < finer.count; ++i) {
            next.settings.noise *= finer.factor;
            next.mse *= finer.factor * finer.factor;
            pilot.finer.push_back(next);
        }
    }

    /// The noise that meets a target by its variance; none where that does not tell.
    std::optional<double> noise_for(const QualityTarget& target) const {
        switch (target.metric) {
            case QualityTarget::Metric::kPsnrDb:
            case QualityTarget::Metric::kRmse:
                return kAim * std::sqrt(largest_square(target));
            case QualityTarget::Metric::kRelMse:
            case QualityTarget::Metric::kSsim:
            case QualityTarget::Metric::kIrradianceRel:
            case QualityTarget::Metric::kRays:
                break;
        }
        return std::nullopt;
    }

    /// That all targets ask for, or the one that asks for least.
    double first_noise(double untold) const {
        std::optional<double> noise;
        for (const QualityTarget& target : job_.quality.targets) {
            const double its = noise_for(target).value_or(untold);
            const bool all = job_.quality.require == Require::kAll;
            noise = !noise ? its : (all ? std::min(*noise, its) : std::max(*noise, its));
        }
        return *noise;
    }

    /// As for leaf rays: few paths in every pixel, whose errors average out over the sphere. How
    /// many it takes is for every probe's own variances to say.
    static void aim_at_irradiance(Pilot& pilot) {
        pilot.settings.samples = kLeastIrradiancePaths;
        pilot.settings_mse = 1.0;
        for (double n = kLeastIrradiancePaths; n < kMostIrradiancePaths;) {
            n = std::min(std::ceil(kMorePaths * n), double{kMostIrradiancePaths});
            RenderSettings finer = pilot.settings;
            finer.samples = static_cast<int>(n);
            pilot.finer.push_back({finer, kLeastIrradiancePaths / n});
        }
    }

    void know_irradiance(Pilot& pilot) {
        norms_ = irradiance_norms(path_noise(), pilot.search_cost);
        pilot.irradiance_square_times_paths = norms_.square_times_paths;
    }

    /// What audits are to compare with, where variances tell: paths err without bias and
    /// independently.
    void steer(Pilot& pilot) const {
        const bool learns = probes_to_learn_from(job_) > 0;
        std::vector<std::optional<Steering>> all;
        for (const QualityTarget& target : job_.quality.targets) {
            all.emplace_back();
            if (target.metric == QualityTarget::Metric::kIrradianceRel) {
                all.back() = steering_of(target, kUsualIrradiancePrior);
            } else if (target.metric == QualityTarget::Metric::kSsim && learns) {
                all.back() = steering_of(target, kSsimPrior);
            }
        }
        const auto told = [](const std::optional<Steering>& its) { return its.has_value(); };
        if (std::any_of(all.begin(), all.end(), told)) pilot.steering = all;
    }

    /// Of one path in every place.
    std::vector<NoisyPixel> path_noise() const {
        std::vector<NoisyPixel> noise;
        for (size_t i = 0; i < places_.size(); ++i) {
            const Place& at = places_[i];
            noise.push_back({at.probe, at.owner, at.view.face_size_px, 3.0 * paths_[i].variance});
        }
        return noise;
    }

    /// Paths per pixel that the budgets leave; none: no budget.
    std::optional<double> affordable(const std::optional<TimeBudget>& time) const {
        std::optional<double> most;
        const auto pixels = static_cast<double>(pixel_count(job_));
        if (job_.budget.rays) most = static_cast<double>(*job_.budget.rays) / pixels;
        if (time) {
            const double per_pixel =
                std::max(2.0, time->per_pixel(job_, seconds()) / seconds_per_path_);
            most = std::min(most.value_or(per_pixel), per_pixel);
        }
        return most;
    }

    /// Numbers of paths of the curve's points: from one on, by fours, to beyond the target or as
    /// far as they may cost.
    std::vector<int> curve_paths(const Pilot& pilot) const {
        const double noise = pilot.settings.noise;
        const bool irradiance = wants_leaf_rays_only(job_);
        const double few = irradiance ? pilot.settings.samples : kLeastPaths;
        const double wanted = noise > kNoNoise * pilot.exposure ? needed(noise) : few;
        const double states = static_cast<double>(job_.states.size());
        const double expected = wanted * static_cast<double>(pixel_count(job_)) / states;
        const double most =
            std::max(double{kLeastPaths}, kShare * expected / static_cast<double>(places_.size()));
        std::vector<int> points;
        for (int n = 1; n <= std::min<double>(most, kMostPathsPerPixel); n *= 4) {
            points.push_back(n);
            if (points.size() >= 5 && n > 2.0 * wanted) break;
        }
        while (points.size() < 5) points.push_back(2 * points.back());
        return points;
    }

    void measure_curve(Pilot& pilot) {
        const std::vector<int> points = curve_paths(pilot);
        trace_truth(std::max(kFirstPaths, points.back()), pilot.search_cost);
        std::vector<std::vector<Rgb>> colors(points.size(), std::vector<Rgb>(places_.size()));
        std::vector<std::vector<CostStats>> costs(points.size(),
                                                  std::vector<CostStats>(places_.size()));
        pilot.curve_cost += for_each_place([&](size_t i, CostStats& stats) {
            const auto start = std::chrono::steady_clock::now();
            PathCount count;
            Vec3 sum(0.0);
            int k = 0;
            for (size_t p = 0; p < points.size(); ++p) {
                for (; k < points[p] && !cancel_.cancelled(); ++k) {
                    const PixelPath name{key(4, i), static_cast<uint32_t>(k)};
                    sum += pixel_path(*tracer_, places_[i].view, places_[i].owner, name, count)
                               .radiance;
                }
                colors[p][i] = Rgb(sum / static_cast<double>(k));
                costs[p][i] = cost_of(count);
                costs[p][i].seconds =
                    std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            }
            stats += cost_of(count);
        });
        for (size_t p = 0; p < points.size(); ++p) {
            CurvePoint point;
            point.settings = {.kind = RendererKind::kPaths, .samples = points[p]};
            CostStats cost;
            for (const CostStats& part : costs[p]) cost += part;
            point.rays = cost.rays;
            point.steps = cost.steps;
            point.seconds = cost.seconds;
            Moments moments;
            std::vector<NoisyPixel> noise;
            for (size_t i = 0; i < places_.size(); ++i) {
                const Place& at = places_[i];
                const double error = squared_error(colors[p][i], paths_[i].truth, pilot.exposure);
                moments.add(weight(at) * error);
                noise.push_back({at.probe, at.owner, at.view.face_size_px,
                                 3.0 * error * pilot.exposure * pilot.exposure});
            }
            point.error.mse = Estimate::of_mean(moments);
            if (wants_leaf_rays_only(job_)) {
                point.error.irradiance_square = expected_irradiance_square(noise, norms_);
            }
            pilot.curve.push_back(point);
        }
    }

    IrradianceNorms irradiance_norms(const std::vector<NoisyPixel>& sample, CostStats& cost) const {
        const auto paths = static_cast<uint32_t>(
            std::clamp<size_t>(kCoarsePaths / job_.probes.size(), kFirstPaths, kMostCoarsePaths));
        IrradianceNorms norms = coarse_irradiance_norms(
            job_.probes, sample, [&](const CoarsePixel& at, CostStats& stats) {
                cancel_.throw_if_cancelled();
                const VolumeView view = volume_view(scene_, at.probe, 0);
                const double n = paths;
                PathCount count;
                Vec3 sum(0.0);
                Vec3 sum2(0.0);
                for (uint32_t k = 0; k < paths; ++k) {
                    const Vec3 radiance =
                        pixel_path(*tracer_, view, at.pixel, {key(5, at.index), k}, count).radiance;
                    sum += radiance;
                    sum2 += radiance * radiance;
                }
                stats += cost_of(count);
                const Vec3 variance = (sum2 - sum * sum / n) / (n - 1.0);
                return CoarseColor{Rgb(sum / n),
                                   std::max(0.0, variance.x + variance.y + variance.z)};
            });
        cost += norms.cost;
        return norms;
    }

    double weight(const Place& place) const {
        return pixel_weight(job_.quality.weighting, place.owner, place.view.face_size_px);
    }

    const Scene& scene_;
    const JobSpec& job_;
    const ReadyState& state_;
    const CancelToken& cancel_;
    const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    const PathTracer* tracer_ = nullptr;
    std::vector<Place> places_;
    std::vector<PlacePaths> paths_;
    IrradianceNorms norms_;  // where irradiance is a target
    double seconds_per_path_ = 0.0;
};

}  // namespace

Pilot run_media_pilot(const Scene& scene, const JobSpec& job, const ReadyState& state,
                      const CancelToken& cancel, const std::optional<TimeBudget>& time) {
    return MediaPilot(scene, job, state, cancel).run(time);
}

}  // namespace probebake
