// The pilot: a sample of a job's pixels, on which its settings are tuned before anything is baked.
//
//   choose pixels of up to 64 probes -> their truth -> exposure
//   -> cast what the candidates could cast -> the cheapest settings whose error bound meets the
//   target
//   -> render the same pixels with a handful of settings: the curve of error against cost
//
// Deterministic: it decides on counted steps. Its pixels never certify anything (audit.h draws
// fresh ones), and its rays are counted apart from the render's.
#pragma once

#include <vector>

#include "bake/error_prior.h"
#include "bake/hidden_light.h"
#include "bake/media_state.h"
#include "bake/pilot_sample.h"
#include "bake/plan.h"

namespace probebake {

/// What the chosen settings promise.
enum class Expectation {
    kTargetMet,
    kBudgetExhausted,  // settings that would meet the target cost more than the budget
    kUnreachable,      // not even the finest settings meet it
};

/// How a target is reached by the hybrid renderer: every probe is refined until the mean squared
/// error that it predicts of itself (metrics' units) is `goal`; and what the pilot knows of how
/// predictions and errors of the target's metric compare.
struct Steering {
    double goal = 0.0;
    ErrorPrior prior;
};

/// A little less than what a bound asks for.
inline constexpr double kNextAim = 0.97;

Steering steering_of(const QualityTarget& target, const ErrorPrior& prior);

struct FinerSettings {
    RenderSettings settings;
    double mse = 0.0;  // as settings_mse; 0 where the sample showed no error any more
};

struct Pilot {
    ReadyState state;
    std::shared_ptr<const MediaState> media;         // where the state is seen through them
    std::shared_ptr<const EmitterSampler> emitters;  // to look for, where no media are
    double exposure = 1.0;
    double largest_radiance = 0.0;         // that the sample showed, or emissive voxels have
    int truth_grid = kTruthGrids.front();  // that audits use, too
    RenderSettings settings;
    double settings_mse = 0.0;  // their mean squared error on the sample; for leaf rays only: 1
    Expectation expectation = Expectation::kTargetMet;
    /// Settings that refine further, cheapest first, for a probe that misses the target.
    std::vector<FinerSettings> finer;
    /// One per target of the job (none for irradiance), where probes are steered; else empty.
    std::vector<std::optional<Steering>> steering;
    /// From LOD only (leaf rays only: from one ray) to beyond the target, cheapest first.
    std::vector<CurvePoint> curve;
    double irradiance_square_times_paths = 0.0;  // IrradianceNorms::square_times_paths
    uint64_t pixels = 0;                         // of the sample
    uint64_t candidates = 0;                     // compared
    CostStats search_cost;
    CostStats audit_cost;  // of the job's first probes, once they have taught
    CostStats curve_cost;
    double wall_seconds = 0.0;
};

/// The predicted mean squared error (radiance over exposure) at which every target that has to be
/// met is expected to be; none where no probe is steered.
std::optional<double> first_goal(const Pilot& pilot, Require require);

/// Of a budget of seconds, what renders are planned to take; the rest is for audits, files and what
/// plans are wrong by.
inline constexpr double kRenderShareOfTime = 0.8;

/// What is left of a job's budget of seconds when the first of its pilots begins, for all pilots
/// and renders. Every lighting state has an equal part, of which its own pilot takes what it needs
/// and its render is planned to take most of the rest. Nothing of it goes over to another state:
/// all pilots run before anything is rendered.
struct TimeBudget {
    int threads = 1;
    double seconds = 0.0;  // wall time

    double of_state(const JobSpec& job) const {
        return seconds / static_cast<double>(job.states.size());
    }
    /// Seconds of a thread that the render of a state is planned to take in a pixel, after a pilot
    /// of so many seconds.
    double per_pixel(const JobSpec& job, double pilot_seconds) const;
};

/// Tunes one lighting state. Runs on the calling arena. Throws Cancelled.
Pilot run_pilot(const Scene& scene, const JobSpec& job, const Plan& plan, const ReadyState& state,
                const CancelToken& cancel, const std::optional<TimeBudget>& time = {});

}  // namespace probebake
