#include "bake/pilot.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bake/leaf_ray_pilot.h"
#include "bake/media_pilot.h"

namespace probebake {
namespace {

/// Of a budget of seconds, what the pilot may use before it takes what it has.
constexpr double kPilotShare = 0.5;

/// What the first look at a probe aims at, of the error that the target allows: what it spares the
/// probes whose error is less than predicted pays for further looks at the others
/// (docs/results/calibration.md).
constexpr double kFirstAim = 0.72;
constexpr double kLargestSpread = 2.0;

/// Points of the curve before the chosen settings, and how far down the frontier beyond them: not
/// at its end, where a pixel may cost hundreds of rays.
constexpr size_t kCurveBefore = 4;
constexpr size_t kCurveBeyond[] = {1, 3};

/// Whether a ray limit leaves out what promises least.
bool spends_where_it_counts(const RenderSettings& settings) {
    return settings.kind == RendererKind::kErrorAware || settings.kind == RendererKind::kHybrid;
}

/// The pilot's own time, beside the budget.
class Stopwatch {
  public:
    Stopwatch(const JobSpec& job, const std::optional<TimeBudget>& budget)
        : job_(job), budget_(budget) {}

    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }
    bool out_of_time() const {
        return budget_ && seconds() > kPilotShare * budget_->of_state(job_);
    }
    /// Whether a render may take so many seconds of a thread in a pixel.
    bool affordable(double seconds_per_pixel) const {
        return !budget_ || seconds_per_pixel <= budget_->per_pixel(job_, seconds());
    }

  private:
    const JobSpec& job_;
    const std::optional<TimeBudget>& budget_;
    const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class Search {
  public:
    Search(const JobSpec& job, const Plan& plan, PilotSample& pixels, const Stopwatch& time)
        : job_(job), sampled_(sampled(job.quality)), plan_(plan), pixels_(pixels), time_(time) {}

    /// Fills the pilot's settings, expectation and finer candidates; returns the whole frontier,
    /// cheapest first, and which of it was chosen.
    std::pair<std::vector<Candidate>, size_t> run(Pilot& pilot) {
        std::vector<Candidate> all = compare(pilot);
        size_t chosen = cheapest_that_meets(all);
        pilot.expectation = Expectation::kTargetMet;
        if (chosen == all.size()) {
            --chosen;  // the finest there is
            if (!estimate_meets(sampled_, all[chosen].error)) {
                pilot.expectation =
                    cut_short_ ? Expectation::kBudgetExhausted : Expectation::kUnreachable;
            }
        }
        const size_t affordable = last_affordable(all);
        if (affordable < chosen) {
            // One finer than the budget pays for on average: the ray limit of each probe then
            // spends what there is where the errors are largest.
            const bool spreads = limited_by_rays() &&
                                 spends_where_it_counts(all[affordable].settings) &&
                                 spends_where_it_counts(all[affordable + 1].settings);
            chosen = spreads ? affordable + 1 : affordable;
            if (!ray_target()) pilot.expectation = Expectation::kBudgetExhausted;
        }
        pilot.settings = all[chosen].settings;
        if (all[chosen].error.mse.nothing_found() && !(all[chosen].predicted > 0.0)) {
            pilot.settings = cautious_settings();
        }
        pilot.settings_mse = all[chosen].error.mse.value;
        if (pilot.settings.kind == RendererKind::kHybrid) {
            pilot.finer = pilot.settings.price < 0.0
                              ? finer_grids(pilot.settings)
                              : lower_prices(pilot.settings.price, pilot.settings_mse);
            if (steers(pilot, all[chosen])) pilot.steering = steering(all[chosen]);
            return {std::move(all), chosen};
        }
        for (size_t i = chosen + 1; i < all.size(); ++i) {
            pilot.finer.push_back({all[i].settings, all[i].error.mse.value});
        }
        for (const RenderSettings& settings : finest_settings(plan_.renderers)) {
            pilot.finer.push_back({settings, 0.0});
        }
        return {std::move(all), chosen};
    }

  private:
    /// Whether probes are refined until their own predictions say so; also where the few pixels of
    /// the sample, one of which may be wrong as few are, say that they cannot be.
    bool steers(const Pilot& pilot, const Candidate& chosen) const {
        return pilot.expectation != Expectation::kBudgetExhausted && !ray_target() &&
               !job_.budget.rays && chosen.predicted > 0.0;
    }

    std::vector<std::optional<Steering>> steering(const Candidate& chosen) const {
        std::vector<std::optional<Steering>> all;
        for (const QualityTarget& target : job_.quality.targets) {
            const std::optional<Estimate> size = error_size(target.metric, chosen.error);
            const std::optional<RatioEstimate> ratio = expected_ratio(chosen, target);
            all.emplace_back();
            if (!ratio) continue;
            const bool windows = target.metric == QualityTarget::Metric::kSsim;
            const double draw_cv = windows ? size->standard_error() / size->value *
                                                 std::sqrt(static_cast<double>(size->samples))
                                           : kUsualPrior.draw_cv;
            all.back() = steering_of(
                target,
                {.ratio = ratio->value,
                 .spread = std::min(kLargestSpread, std::hypot(kUsualSpread, ratio->known_to)),
                 .draw_cv = draw_cv,
                 .common = ratio->known_to});
        }
        return all;
    }

    struct RatioEstimate {
        double value = 1.0;
        double known_to = 0.0;  // relative standard deviation
    };

    /// Of actual over predicted error. The few pixels of a sample may hold one that is wrong as
    /// few are, or none of them: of squared errors, what is usual counts beside what they say.
    std::optional<RatioEstimate> expected_ratio(const Candidate& candidate,
                                                const QualityTarget& target) const {
        const std::optional<Estimate> size = error_size(target.metric, candidate.error);
        if (!size || !(candidate.predicted > 0.0)) return std::nullopt;
        const bool of_squares = is_of_squares(target.metric);
        if (!of_squares && !tells(*size)) return std::nullopt;
        const double measured = std::max(0.0, size->value) / candidate.predicted;
        const double error = size->standard_error() / candidate.predicted;
        const double own = measured > 0.0 ? measured * measured / (error * error) : 0.0;
        const double usual = of_squares ? 1.0 / (kUsualSpread * kUsualSpread) : 0.0;
        return RatioEstimate{(usual * kUsualPrior.ratio + own * measured) / (usual + own),
                             1.0 / std::sqrt(usual + own)};
    }

    /// By what the pilot's pixels say and what is usual.
    bool expected_to_meet(const Candidate& candidate) const {
        return targets_meet(sampled_, [&](const QualityTarget& target) {
            const auto ratio = expected_ratio(candidate, target);
            return ratio ? ratio->value * candidate.predicted <= kFirstAim * *largest_size(target)
                         : estimate_meets(target, candidate.error);
        });
    }

    /// Where nothing is predicted: more rays in every pixel.
    static std::vector<FinerSettings> finer_grids(RenderSettings settings) {
        std::vector<FinerSettings> finer;
        while (settings.leaf_grid < hybrid_at(0.0).leaf_grid) {
            settings.leaf_grid *= 2;
            finer.push_back({settings, 0.0});
        }
        return finer;
    }

    /// Prices in steps of two. Their errors are guessed: at half the price the squared error is
    /// 0.58 to 0.85 of what it was, 0.70 on average (docs/decisions.md). Then rays in every pixel.
    static std::vector<FinerSettings> lower_prices(double price, double mse) {
        constexpr int kCount = 24;
        std::vector<FinerSettings> finer;
        for (int i = 0; i < kCount && price > 0.0; ++i) {
            price *= 0.5;
            mse *= 0.7;
            finer.push_back({hybrid_at(price), mse});
        }
        // What they do not reach: all first rays of a neighbourhood saw the same.
        for (const int least_grid : {4, 8, 16}) {
            RenderSettings settings = hybrid_at(0.0);
            settings.least_grid = least_grid;
            finer.push_back({settings, 0.0});
        }
        return finer;
    }

    /// Compares lower and lower prices, until some meet the target.
    std::vector<Candidate> compare_prices(Pilot& pilot) {
        constexpr double kNextPrice = 0.25;
        pixels_.extend_hybrid(std::numeric_limits<double>::infinity());
        double price = 0.0;
        for (const SearchPixel& pixel : pixels_.sample().pixels) {
            price = std::max(price, pixel.hybrid.gain());
        }
        const double lowest = price * 0x1.0p-60;
        for (;;) {
            price *= kNextPrice;
            if (price <= lowest) price = -1.0;  // nothing is left to refine, or never was
            pixels_.extend_hybrid(price);
            std::vector<Candidate> candidates =
                evaluate_all(hybrid_settings(pixels_.sample(), price));
            pilot.candidates = candidates.size();
            const bool enough = is_enough(candidates);
            std::vector<Candidate> best = frontier(std::move(candidates), sampled_);
            cut_short_ = !enough && price >= 0.0 && time_.out_of_time();
            if (enough || price < 0.0 || cut_short_) return best;
        }
    }

    std::vector<Candidate> evaluate_all(const std::vector<RenderSettings>& settings) const {
        std::vector<Candidate> candidates(settings.size());
        tbb::parallel_for(size_t{0}, settings.size(), [&](size_t i) {
            candidates[i] = evaluate(pixels_.sample(), settings[i]);
        });
        return candidates;
    }

    /// Whether no finer candidates are needed: some meet the target, or cost more than may be
    /// spent.
    bool is_enough(const std::vector<Candidate>& candidates) const {
        if (!ray_target()) {
            return cheapest_that_meets(candidates) < candidates.size();
        }
        return std::any_of(candidates.begin(), candidates.end(),
                           [&](const Candidate& candidate) { return !affordable(candidate); });
    }

    /// Compares candidates with finer and finer leaf rays, until some meet the target.
    std::vector<Candidate> compare(Pilot& pilot) {
        const RendererKind kind = plan_.renderers.front();
        if (pays_by_price()) return compare_prices(pilot);
        const bool refines_further = kind != RendererKind::kLod && kind != RendererKind::kAdaptive;
        std::vector<Candidate> best;
        for (const int leaf_grid : kLeafGrids) {
            pixels_.extend(plan_.renderers, leaf_grid);
            const std::vector<RenderSettings> settings =
                candidate_settings(pixels_.sample(), plan_.renderers, leaf_grid);
            std::vector<Candidate> candidates = evaluate_all(settings);
            pilot.candidates = candidates.size();
            const bool enough = is_enough(candidates);
            best = frontier(std::move(candidates), sampled_);
            cut_short_ =
                !enough && refines_further && leaf_grid < kLeafGrids.back() && time_.out_of_time();
            if (enough || !refines_further || cut_short_) break;
        }
        return best;
    }

    /// Where the sample shows no error at all, what is wrong may be rarer than its pixels: sixteen
    /// rays in every pixel, not the single one that happened to be enough.
    RenderSettings cautious_settings() const {
        switch (plan_.renderers.front()) {
            case RendererKind::kErrorAware:
                return {.threshold = -1.0};
            case RendererKind::kHybrid:
                return {.kind = RendererKind::kHybrid, .leaf_grid = 4, .price = -1.0};
            case RendererKind::kReference:
                return {.kind = RendererKind::kReference};
            case RendererKind::kAdaptive:
                return finest_settings(plan_.renderers).front();
            case RendererKind::kLod:
            case RendererKind::kPaths:
                break;
        }
        return {.kind = RendererKind::kLod};
    }

    /// All of them where the target is a number of rays: what is affordable decides.
    size_t cheapest_that_meets(const std::vector<Candidate>& all) const {
        if (ray_target()) return all.size() - 1;
        const auto at = std::find_if(all.begin(), all.end(), [&](const Candidate& candidate) {
            return pays_by_price()
                       ? expected_to_meet(candidate)
                       : bound_meets(sampled_, candidate.error, job_.quality.evidence.confidence);
        });
        return static_cast<size_t>(at - all.begin());
    }

    /// The cheapest candidate counts as affordable whatever it costs.
    size_t last_affordable(const std::vector<Candidate>& all) const {
        size_t last = 0;
        for (size_t i = 1; i < all.size(); ++i) {
            if (affordable(all[i])) last = i;
        }
        return last;
    }

    bool affordable(const Candidate& candidate) const {
        const auto pixels = static_cast<double>(pixel_count(job_));
        if (ray_target()) {
            const double rays_per_pixel = job_.quality.targets.front().value *
                                          static_cast<double>(job_.probes.size()) *
                                          static_cast<double>(job_.states.size()) / pixels;
            if (candidate.rays_per_pixel > rays_per_pixel) return false;
        }
        if (job_.budget.rays &&
            candidate.rays_per_pixel * pixels > static_cast<double>(*job_.budget.rays)) {
            return false;
        }
        const CostStats& spent = pixels_.search_cost();
        const double seconds_per_step =
            spent.steps > 0 ? spent.seconds / static_cast<double>(spent.steps) : 0.0;
        return time_.affordable(candidate.steps_per_pixel * seconds_per_step);
    }

    bool ray_target() const { return only_target(job_.quality, QualityTarget::Metric::kRays); }
    /// The job's targets without irradiance, which a sample of pixels does not tell.
    static QualitySpec sampled(QualitySpec quality) {
        auto& targets = quality.targets;
        targets.erase(std::remove_if(targets.begin(), targets.end(),
                                     [](const QualityTarget& target) {
                                         return target.metric ==
                                                QualityTarget::Metric::kIrradianceRel;
                                     }),
                      targets.end());
        return quality;
    }
    bool pays_by_price() const { return plan_.renderers.front() == RendererKind::kHybrid; }
    bool limited_by_rays() const { return ray_target() || job_.budget.rays; }

    const JobSpec& job_;
    const QualitySpec sampled_;
    const Plan& plan_;
    PilotSample& pixels_;
    const Stopwatch& time_;
    bool cut_short_ = false;  // there are finer candidates, but no time to look at them
};

/// Settings of the curve: LOD only, some of the way to the chosen ones, these, and beyond.
std::vector<RenderSettings> curve_settings(const std::vector<Candidate>& frontier, size_t chosen,
                                           const RenderSettings& used) {
    std::vector<RenderSettings> settings{{.kind = RendererKind::kLod}};
    const auto add = [&](const RenderSettings& s) {
        if (std::find(settings.begin(), settings.end(), s) == settings.end()) settings.push_back(s);
    };
    for (size_t i = 0; i < kCurveBefore; ++i) add(frontier[i * chosen / kCurveBefore].settings);
    add(frontier[chosen].settings);
    add(used);
    for (const size_t beyond : kCurveBeyond) {
        add(frontier[std::min(frontier.size() - 1, chosen + beyond)].settings);
    }
    return settings;
}

/// Where the client brought settings of its own.
std::vector<RenderSettings> curve_settings(const RenderSettings& given) {
    return {{.kind = RendererKind::kLod}, given, {.kind = RendererKind::kReference}};
}

/// Root mean square over the channels, of what the sample shows.
double largest_radiance(const SearchSample& sample) {
    double largest = 0.0;
    for (const SearchPixel& pixel : sample.pixels) {
        for (const Rgb& truth : {pixel.truth.r1, pixel.truth.r2}) {
            largest = std::max(largest, glm::length(Vec3(truth)) / std::sqrt(3.0));
        }
    }
    return largest;
}

}  // namespace

Steering steering_of(const QualityTarget& target, const ErrorPrior& prior) {
    return {.goal = kFirstAim * *largest_size(target) / prior.ratio, .prior = prior};
}

double TimeBudget::per_pixel(const JobSpec& job, double pilot_seconds) const {
    const double pixels =
        static_cast<double>(pixel_count(job)) / static_cast<double>(job.states.size());
    return kRenderShareOfTime * std::max(0.0, of_state(job) - pilot_seconds) * threads / pixels;
}

std::optional<double> first_goal(const Pilot& pilot, Require require) {
    std::optional<double> goal;
    for (const std::optional<Steering>& target : pilot.steering) {
        if (!target) continue;
        const bool all = require == Require::kAll;
        goal = !goal ? target->goal
                     : (all ? std::min(*goal, target->goal) : std::max(*goal, target->goal));
    }
    return goal;
}

Pilot run_pilot(const Scene& scene, const JobSpec& job, const Plan& plan, const ReadyState& state,
                const CancelToken& cancel, const std::optional<TimeBudget>& time) {
    if (sees_media(scene, state.spec)) return run_media_pilot(scene, job, state, cancel, time);
    const Stopwatch stopwatch(job, time);
    PilotSample pixels(scene, job, state, cancel);
    Pilot pilot{
        .state = state, .exposure = pixels.sample().exposure, .truth_grid = pixels.truth_grid()};
    pilot.largest_radiance = largest_radiance(pixels.sample());
    if (job.quality.evidence.audit) {
        pilot.emitters = emitters_to_look_for(scene, state.spec);
    }
    if (pilot.emitters) {
        pilot.largest_radiance =
            std::max(pilot.largest_radiance, pilot.emitters->largest_radiance());
    }
    std::vector<RenderSettings> measured;
    if (state.spec == LightingState::kEmission && !scene.emits()) {
        pilot.settings = {.kind = RendererKind::kLod};  // black, whatever is cast
        measured = {pilot.settings};
    } else if (plan.leaf_rays_only) {
        begin_with_one_ray(pilot);
        measured = leaf_ray_curve(pilot);
    } else if (plan.needs_pilot) {
        const auto [frontier, chosen] = Search(job, plan, pixels, stopwatch).run(pilot);
        measured = curve_settings(frontier, chosen, pilot.settings);
    } else {
        pilot.settings = *job.quality.settings;
        // These two look at neighbours.
        if (pilot.settings.kind == RendererKind::kAdaptive) {
            pixels.extend({pilot.settings.kind}, kLeafGrids.front());
        } else if (pilot.settings.kind == RendererKind::kHybrid) {
            pixels.extend_hybrid(pilot.settings.price);
        }
        measured = curve_settings(pilot.settings);
    }
    for (const RenderSettings& settings : measured) {
        if (stopwatch.out_of_time() && settings != pilot.settings) continue;
        // What was recorded is not cast again.
        if (settings.kind == RendererKind::kHybrid && settings.price >= pixels.recorded_price()) {
            pilot.curve.push_back(pixels.replayed(settings));
            continue;
        }
        pilot.curve.push_back(settings.shifted_grid ? pixels.render_leaf_rays(settings)
                                                    : pixels.render(settings));
        const CurvePoint& point = pilot.curve.back();
        pilot.curve_cost.rays += point.rays;
        pilot.curve_cost.steps += point.steps;
        pilot.curve_cost.seconds += point.seconds;
    }
    std::stable_sort(pilot.curve.begin(), pilot.curve.end(),
                     [](const CurvePoint& a, const CurvePoint& b) { return a.steps < b.steps; });
    if (plan.leaf_rays_only) learn_from_leaf_ray_curve(pilot, job);
    pilot.pixels = pixels.sample().pixels.size();
    pilot.search_cost = pixels.search_cost();
    pilot.wall_seconds = stopwatch.seconds();
    return pilot;
}

}  // namespace probebake
