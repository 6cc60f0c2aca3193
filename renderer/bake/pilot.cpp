#include "bake/pilot.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "bake/media_pilot.h"

namespace probebake {
namespace {

/// Of a budget of seconds, what the pilot may use before it takes what it has.
constexpr double kPilotShare = 0.5;

/// Prices that are tried, each a quarter of the one before, after the first whose estimate meets
/// the target: if the bound does not come down by then, it hangs on single pixels that no price
/// reaches, and the looks at each probe have to tell.
constexpr int kFurtherPrices = 2;

/// Points of the curve before the chosen settings, and how far down the frontier beyond them: not
/// at its end, where a pixel may cost hundreds of rays.
constexpr size_t kCurveBefore = 4;
constexpr size_t kCurveBeyond[] = {1, 3};

/// Whether a ray limit leaves out what promises least.
bool spends_where_it_counts(const RenderSettings& settings) {
    return settings.kind == RendererKind::kErrorAware || settings.kind == RendererKind::kHybrid;
}

class Search {
  public:
    Search(const JobSpec& job, const Plan& plan, PilotSample& pixels,
           const std::optional<TimeBudget>& time, const std::function<bool()>& out_of_time)
        : job_(job), plan_(plan), pixels_(pixels), time_(time), out_of_time_(out_of_time) {}

    /// Fills the pilot's settings, expectation and finer candidates; returns the whole frontier,
    /// cheapest first, and which of it was chosen.
    std::pair<std::vector<Candidate>, size_t> run(Pilot& pilot) {
        std::vector<Candidate> all = compare(pilot);
        size_t chosen = cheapest_that_meets(all);
        if (chosen == all.size() && pays_by_price()) chosen = first_by_estimate(all);
        pilot.expectation = Expectation::kTargetMet;
        if (chosen == all.size()) {
            --chosen;  // the finest there is
            if (!estimate_meets(job_.quality.target, all[chosen].error)) {
                pilot.expectation = Expectation::kUnreachable;
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
        if (all[chosen].error.mse.nothing_found()) pilot.settings = cautious_settings();
        pilot.settings_mse = all[chosen].error.mse.value;
        if (pilot.settings.kind == RendererKind::kHybrid) {
            pilot.finer = lower_prices(pilot.settings.price, pilot.settings_mse);
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
    /// Prices in steps of two. Their errors are guessed: at half the price the squared error is
    /// 0.58 to 0.85 of what it was, 0.70 on average (docs/decisions.md).
    static std::vector<FinerSettings> lower_prices(double price, double mse) {
        constexpr int kCount = 24;
        std::vector<FinerSettings> finer;
        for (int i = 0; i < kCount && price > 0.0; ++i) {
            price *= 0.5;
            mse *= 0.7;
            finer.push_back({hybrid_at(price), mse});
        }
        return finer;
    }

    /// Compares lower and lower prices, until some meet the target.
    std::vector<Candidate> compare_prices(Pilot& pilot) {
        constexpr double kNextPrice = 0.25;
        int further = kFurtherPrices;
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
            std::vector<Candidate> best = frontier(std::move(candidates), job_.quality.target);
            if (!ray_target() && first_by_estimate(best) < best.size()) --further;
            if (enough || further < 0 || price < 0.0 || out_of_time_()) return best;
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
        if (!ray_target()) return cheapest_that_meets(candidates) < candidates.size();
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
            best = frontier(std::move(candidates), job_.quality.target);
            if (enough || !refines_further || out_of_time_()) break;
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
            return bound_meets(job_.quality.target, candidate.error,
                               job_.quality.evidence.confidence);
        });
        return static_cast<size_t>(at - all.begin());
    }

    /// The first whose estimate meets the target, with some certainty if possible.
    size_t first_by_estimate(const std::vector<Candidate>& all) const {
        const QualityTarget& target = job_.quality.target;
        auto at = std::find_if(all.begin(), all.end(), [&](const Candidate& candidate) {
            return bound_meets(target, candidate.error, kLookConfidence);
        });
        if (at == all.end()) {
            at = std::find_if(all.begin(), all.end(), [&](const Candidate& candidate) {
                return estimate_meets(target, candidate.error);
            });
        }
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
            const double rays_per_pixel = job_.quality.target.value *
                                          static_cast<double>(job_.probes.size()) *
                                          static_cast<double>(job_.states.size()) / pixels;
            if (candidate.rays_per_pixel > rays_per_pixel) return false;
        }
        if (job_.budget.rays &&
            candidate.rays_per_pixel * pixels > static_cast<double>(*job_.budget.rays)) {
            return false;
        }
        if (time_) {
            const CostStats& spent = pixels_.search_cost();
            const double seconds_per_step =
                spent.steps > 0 ? spent.seconds / static_cast<double>(spent.steps) : 0.0;
            const double seconds =
                candidate.steps_per_pixel * pixels * seconds_per_step / time_->threads;
            if (seconds > time_->seconds) return false;
        }
        return true;
    }

    bool ray_target() const { return job_.quality.target.metric == QualityTarget::Metric::kRays; }
    bool pays_by_price() const { return plan_.renderers.front() == RendererKind::kHybrid; }
    bool limited_by_rays() const { return ray_target() || job_.budget.rays; }

    const JobSpec& job_;
    const Plan& plan_;
    PilotSample& pixels_;
    const std::optional<TimeBudget>& time_;
    const std::function<bool()>& out_of_time_;
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

/// One leaf ray per pixel, then finer grids for probes that miss the target. Squared errors in
/// units of what one ray leaves: they fall like the variance of stratified means, and so does the
/// square of an audit's interval that costs a share of its render (irradiance_truth_grid).
void begin_with_one_ray(Pilot& pilot) {
    constexpr std::array kFiner = {2, 3, 4, 8, 16};
    pilot.settings = {.kind = RendererKind::kReference, .leaf_grid = 1};
    pilot.settings_mse = 1.0;
    for (const int grid : kFiner) {
        pilot.finer.push_back(
            {{.kind = RendererKind::kReference, .leaf_grid = grid}, 1.0 / (grid * grid * grid)});
    }
}

}  // namespace

Pilot run_pilot(const Scene& scene, const JobSpec& job, const Plan& plan, const ReadyState& state,
                const CancelToken& cancel, const std::optional<TimeBudget>& time) {
    if (sees_media(scene, state.spec)) return run_media_pilot(scene, job, state, cancel, time);
    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [start] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    const std::function<bool()> out_of_time = [&] {
        return time && seconds() > kPilotShare * time->seconds;
    };
    PilotSample pixels(scene, job, state, cancel);
    Pilot pilot{
        .state = state, .exposure = pixels.sample().exposure, .truth_grid = pixels.truth_grid()};
    std::vector<RenderSettings> measured;
    if (state.spec == LightingState::kEmission && !scene.emits()) {
        pilot.settings = {.kind = RendererKind::kLod};  // black, whatever is cast
        measured = {pilot.settings};
    } else if (plan.leaf_rays_only) {
        begin_with_one_ray(pilot);
    } else if (plan.needs_pilot) {
        const auto [frontier, chosen] = Search(job, plan, pixels, time, out_of_time).run(pilot);
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
        if (out_of_time() && settings != pilot.settings) continue;
        pilot.curve.push_back(pixels.render(settings));
        const CurvePoint& point = pilot.curve.back();
        pilot.curve_cost.rays += point.rays;
        pilot.curve_cost.steps += point.steps;
        pilot.curve_cost.seconds += point.seconds;
    }
    std::stable_sort(pilot.curve.begin(), pilot.curve.end(),
                     [](const CurvePoint& a, const CurvePoint& b) { return a.steps < b.steps; });
    pilot.pixels = pixels.sample().pixels.size();
    pilot.search_cost = pixels.search_cost();
    pilot.wall_seconds = seconds();
    return pilot;
}

}  // namespace probebake
