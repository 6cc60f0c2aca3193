#include "study/calibration/calibrated_job.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "bake/bake_probe.h"
#include "bake/learn.h"
#include "bake/probe_view.h"
#include "image/exr.h"
#include "render/hybrid_view.h"
#include "scene/suggest_probes.h"

namespace probebake::study {
namespace {

constexpr uint64_t kProbeSeed = 2021;
constexpr int kTruthGrid = 16;
/// Prices of the brute force: so many to a factor of two.
constexpr int kPricesPerOctave = 4;
constexpr int kOctaves = 40;
/// Brute force ends where the error is this much below the target's.
constexpr double kFarBelow = 0.4;
constexpr double kShareThatMeets = 0.95;

JobSpec job_of(std::span<const Vec3> places, const CalibratedJob& what) {
    Json request = {{"scene", "calibrated"}, {"face_size_px", what.face_size_px}};
    int i = 0;
    for (const Vec3& p : places) {
        request["probes"]["list"].push_back(
            {{"id", "p" + std::to_string(i++)}, {"position_m", {p.x, p.y, p.z}}});
    }
    request["quality"]["targets"]["psnr_db"] = what.psnr_db;
    if (what.lit) {
        request["lighting_states"] = {
            {{"id", "morning"},
             {"sun",
              {{"direction", {0.7, 0.45, 0.3}}, {"irradiance_w_m2", {560, 470, 340}}, {"rays", 2}}},
             {"sky",
              {{"type", "gradient"},
               {"zenith_w_m2_sr", {9, 18, 38}},
               {"horizon_w_m2_sr", {38, 46, 55}},
               {"ground_w_m2_sr", {6, 6, 5}},
               {"rays", 16},
               {"gather_m", 4}}}}};
    }
    return read_job(request);
}

/// The true errors of one probe's cubemaps.
class ProbeTruth {
  public:
    ProbeTruth(const RenderScene& what, const Vec3& origin, int n, double exposure, uint64_t key)
        : n_(n), exposure_(exposure), truth_(6 * static_cast<size_t>(n * n)) {
        tbb::parallel_for(size_t{0}, truth_.size(), [&](size_t i) {
            const CubePixel pixel = pixel_at(i, n);
            if (owner_of(pixel, n) != pixel) return;
            CostStats stats;
            truth_[i] =
                truth_pair(what, cube_face_view(pixel.face, n, origin), pixel.x, pixel.y,
                           {.grid = kTruthGrid, .key = random_key({kProbeSeed, key, i})}, stats);
        });
        for_each_shared_pixel(n, [&](const CubePixel& pixel, const CubePixel& owner) {
            truth_[cube_index(pixel, n)] = truth_[cube_index(owner, n)];
        });
    }

    double mse(const Cubemap& written) const {
        double sum = 0.0;
        for (size_t i = 0; i < truth_.size(); ++i) {
            sum += squared_error(written.at(pixel_at(i, n_)), truth_[i], exposure_);
        }
        return sum / static_cast<double>(truth_.size());
    }

  private:
    int n_;
    double exposure_;
    std::vector<TruthPair> truth_;
};

/// Error and cost of a probe at every price of the brute force, from the highest down.
struct PricedProbe {
    std::vector<double> mse;
    std::vector<double> steps;

    /// Steps at the first price from which on the target is met; none: the last there is.
    double cheapest(double allowed) const {
        for (size_t k = 0; k < mse.size(); ++k) {
            if (mse[k] <= allowed) return steps[k];
        }
        return steps.back();
    }
};

PricedProbe price_probe(const RenderScene& what, const Vec3& origin, int n, double exposure,
                        const ProbeTruth& truth, double allowed) {
    const CancelToken cancel;
    HybridCubemap cubemap(what, origin, n, cancel);
    PricedProbe priced;
    for (int k = 0; k < kOctaves * kPricesPerOctave; ++k) {
        const double price = exposure * exposure * std::exp2(-1.0 * k / kPricesPerOctave);
        if (!priced.mse.empty() && price >= cubemap.largest_gain()) {
            priced.mse.push_back(priced.mse.back());
            priced.steps.push_back(priced.steps.back());
            continue;
        }
        cubemap.refine_to(price);
        const CubemapRender render = cubemap.render();
        priced.mse.push_back(truth.mse(rounded_to_file(render.color)));
        priced.steps.push_back(static_cast<double>(render.total().steps));
        if (priced.mse.back() < kFarBelow * allowed) break;
    }
    return priced;
}

/// Steps of all probes together at the highest price at which `meets(errors)` says yes.
template <class Meets>
double cheapest_single_price(const std::vector<PricedProbe>& probes, Meets meets) {
    size_t longest = 0;
    for (const PricedProbe& probe : probes) longest = std::max(longest, probe.mse.size());
    double steps = 0.0;
    for (size_t k = 0; k < longest; ++k) {
        std::vector<double> mse;
        steps = 0.0;
        for (const PricedProbe& probe : probes) {
            const size_t at = std::min(k, probe.mse.size() - 1);
            mse.push_back(probe.mse[at]);
            steps += probe.steps[at];
        }
        if (meets(mse)) break;
    }
    return steps;
}

Json interval_json(const Interval& interval) { return {interval.low, interval.high}; }

Json row_of(const ProbeResult& result, const ProbeTruth& truth, const PricedProbe& priced,
            double allowed) {
    const Cubemap written = decode_cubemap(result.files.front().bytes, "cube.exr").cubemap;
    const Audit& audit = result.certificate;
    Json row = {{"met", result.target_met},
                {"by_probe", result.evidence == EvidenceOf::kProbe},
                {"looks", result.looks},
                {"mse", truth.mse(written)},
                {"predicted", audit.predicted},
                {"pixels", audit.pixels},
                {"render_steps", result.render_cost().steps},
                {"replaced_steps", result.earlier_renders.steps},
                {"audit_steps", audit.cost.steps + result.decision_cost.steps},
                {"cheapest_steps", priced.cheapest(allowed)}};
    if (audit.pixels > 0) {
        row["estimate"] = audit.error.mse.value;
        row["interval"] = interval_json(audit.error.mse.interval(result.confidence));
    }
    // As the report says it: where a probe's own audit alone counts, that is its own.
    const bool pooled = !result.pooled.empty() && result.pooled.front();
    row["pooled_estimate"] = pooled ? Json(result.pooled.front()->value) : row["estimate"];
    row["pooled_interval"] =
        pooled ? interval_json(result.pooled.front()->interval) : row["interval"];
    return row;
}

Json calibrate_job(const Scene& scene, const CalibratedJob& what, const JobSpec& job,
                   const ReadyState& state) {
    const CancelToken cancel;
    const Plan plan = make_plan(scene, job);
    Pilot pilot = run_pilot(scene, job, plan, state, cancel);
    const double allowed = largest_square(job.quality.targets.front());
    const size_t count = job.probes.size();
    std::vector<ProbeResult> results(count);
    const auto bake = [&](size_t begin, size_t end, bool teach) {
        tbb::parallel_for(begin, end, [&](size_t i) {
            results[i] = bake_probe(scene, job, pilot, {.probe = i, .teaches = teach}, cancel);
        });
    };
    const auto steering_json = [&]() -> Json {
        if (pilot.steering.empty() || !pilot.steering.front()) return nullptr;
        const Steering& steering = *pilot.steering.front();
        return {{"goal", steering.goal},
                {"ratio", steering.prior.ratio},
                {"spread", steering.prior.spread},
                {"draw_cv", steering.prior.draw_cv}};
    };
    const Json steering_before = steering_json();
    const size_t first = probes_to_learn_from(job);
    bake(0, first, true);
    learn(pilot, job.quality, std::span(results).first(first));
    bake(first, count, false);

    std::vector<PricedProbe> priced(count);
    std::vector<Json> rows(count);
    tbb::parallel_for(size_t{0}, count, [&](size_t i) {
        const RenderScene view = render_scene(scene, job.probes[i], state);
        const Vec3 origin = scene.to_voxels(job.probes[i].position_m);
        const int n = what.face_size_px;
        const ProbeTruth truth(view, origin, n, pilot.exposure, i);
        priced[i] = price_probe(view, origin, n, pilot.exposure, truth, allowed);
        rows[i] = row_of(results[i], truth, priced[i], allowed);
    });
    const auto most_meet = [&](const std::vector<double>& mse) {
        const auto meeting =
            std::count_if(mse.begin(), mse.end(), [&](double one) { return one <= allowed; });
        return static_cast<double>(meeting) >= kShareThatMeets * static_cast<double>(mse.size());
    };
    const auto mean_meets = [&](const std::vector<double>& mse) {
        return std::accumulate(mse.begin(), mse.end(), 0.0) <=
               allowed * static_cast<double>(mse.size());
    };
    return {{"allowed", allowed},
            {"steering_before", steering_before},
            {"steering", steering_json()},
            {"pilot_steps", pilot.search_cost.steps + pilot.curve_cost.steps},
            {"one_price_steps", cheapest_single_price(priced, most_meet)},
            {"one_price_for_the_mean_steps", cheapest_single_price(priced, mean_meets)},
            {"rows", rows}};
}

}  // namespace

Json calibrate_job(const Scene& scene, const CalibratedJob& what) {
    const std::vector<Vec3> places = suggest_probes(scene, what.probes, kProbeSeed);
    const ReadyState state = light_state(scene, job_of(places, what), 0, CancelToken());
    const auto per_job = static_cast<size_t>(what.probes_per_job.value_or(what.probes));
    Json all;
    for (size_t begin = 0; begin < places.size(); begin += per_job) {
        const size_t count = std::min(per_job, places.size() - begin);
        const JobSpec job = job_of(std::span(places).subspan(begin, count), what);
        Json one = calibrate_job(scene, what, job, state);
        if (all.is_null()) {
            all = std::move(one);
            continue;
        }
        for (const char* steps :
             {"pilot_steps", "one_price_steps", "one_price_for_the_mean_steps"}) {
            all[steps] = all[steps].get<double>() + one[steps].get<double>();
        }
        for (Json& row : one["rows"]) all["rows"].push_back(std::move(row));
    }
    return all;
}

}  // namespace probebake::study
