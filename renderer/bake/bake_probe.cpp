#include "bake/bake_probe.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "bake/learn.h"
#include "bake/probe_audit.h"
#include "bake/probe_files.h"
#include "bake/probe_view.h"
#include "bake/render_noise.h"
#include "image/exr.h"
#include "render/hybrid.h"
#include "render/hybrid_view.h"

namespace probebake {
namespace {

constexpr int kMaxLooks = 6;
/// An audit tells by itself from so many draws on, over the square of a draw's relative standard
/// deviation: its own is within 0.3 then.
constexpr double kTellingDraws = 12.0;
/// Where a probe cannot be refined, or is as good as met, the next audit looks harder: so many
/// times the rays.
constexpr double kHarderLook = 4.0;
constexpr double kHardestLook = 16.0;
/// As good as met, for leaf rays alone, at this confidence.
constexpr double kLeafRaysConfidence = 0.7;
/// Of a render's steps, what all audits of a probe may cost where others tell as well, and where
/// the others learn from it; of its rays, what tells of a render that none has told of.
constexpr double kAudits = 0.09;
constexpr double kTeachingAudits = 0.2;
constexpr double kLeastTold = 0.02;

/// Prices are lowered by this factor until a probe's prediction meets its goal.
constexpr double kPriceStep = 0.9;
/// A probe that missed aims at what the bound says (kNextAim), within these factors.
constexpr double kSmallestStep = 0.25;
constexpr double kLargestStep = 0.95;
/// Looks until which a probe is refined where it predicts errors, and there alone; then all its
/// pixels get so many rays a side, and twice as many with every look.
constexpr int kPredictedLooks = 3;
constexpr int kFirstLeastGrid = 4;
/// In fewer, what one ray misses in one of them weighs too much: all get four more at once.
constexpr uint64_t kFewPixels = 64;

double steps_per_ray(const CostStats& cost) {
    return static_cast<double>(cost.steps) /
           static_cast<double>(std::max(uint64_t{1}, cost.all_rays()));
}

class Unit {
  public:
    Unit(const Scene& scene, const JobSpec& job, const Pilot& pilot, const UnitParams& params,
         const CancelToken& cancel)
        : scene_(scene),
          job_(job),
          pilot_(pilot),
          params_(params),
          probe_(job.probes[params.probe]),
          cancel_(cancel),
          render_scene_(render_scene(scene, probe_, pilot.state)),
          origin_(scene.to_voxels(probe_.position_m)),
          render_mse_(pilot.settings_mse) {
        if (job.products.ddgi) {
            render_scene_.near_limit =
                ddgi_max_distance_m(*grid_of(job, params.probe)) / scene.voxel_size_m;
        }
    }

    ProbeResult run() {
        const auto start = std::chrono::steady_clock::now();
        result_.probe = params_.probe;
        result_.state = pilot_.state.spec;
        result_.far_m = through_media() ? effective_far_through_media_m(scene_, probe_)
                                        : effective_far_m(scene_, probe_);
        result_.inside_voxel = scene_.inside_voxel(probe_.position_m);
        if (steered()) {
            refine_until_good();
        } else {
            render_until_good();
        }
        result_.limited = render_.limited || params_.out_of_time;
        result_.faces = render_.faces;
        result_.pixels = render_.pixels;
        make_files(rendered(), result_);
        result_.wall_seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return std::move(result_);
    }

  private:
    bool audits() const { return job_.quality.evidence.audit; }

    bool steered() const {
        return !params_.out_of_time && !through_media() && !ray_limit(job_, probe_) &&
               !rendered().leaf_rays_only() && first_goal(pilot_, job_.quality.require).has_value();
    }

    /// One cubemap, refined further until its bound meets the target. What the first looks do not
    /// reach is not predicted: it lies in pixels whose few rays all saw the same. Then every pixel
    /// gets more of them.
    void refine_until_good() {
        HybridCubemap cubemap(render_scene_, origin_, probe_.face_size_px, cancel_);
        reveal_hidden_light(cubemap);
        const std::vector<double> weights =
            owned_pixel_weights(job_.quality.weighting, probe_.face_size_px, pilot_.exposure);
        double goal = *first_goal(pilot_, job_.quality.require);
        // What the pilot found of the finest settings holds for these alone.
        const bool finest_alone = pilot_.settings.price < 0.0;
        double price = finest_alone ? 0.0 : cubemap.largest_gain();
        RenderSettings settings = hybrid_at(price);
        if (owned_pixel_count(probe_.face_size_px) < kFewPixels) settings.least_grid = 2;
        if (finest_alone) settings.least_grid = settings.leaf_grid;
        const double lowest = price * 0x1.0p-60;
        for (;;) {
            double predicted = cubemap.predicted_sum(weights);
            while (predicted > goal && price > lowest) {
                price *= kPriceStep;
                cubemap.refine_to(price, settings.least_grid);
                predicted = cubemap.predicted_sum(weights);
            }
            const bool finest = price <= lowest;
            settings.price = finest ? 0.0 : price;
            cubemap.refine_to(settings.price, settings.least_grid);
            result_.settings = settings;
            take(cubemap.render());
            if (!audits()) return;
            look();
            if (result_.target_met || only_others_tell() || result_.looks == kMaxLooks) return;
            const bool everything = casts_all_leaf_rays(settings);
            const bool harder = finest && (everything || audit_effort_ == 1.0) && may_look_harder();
            if (everything && !harder) return;
            ++result_.looks;
            if (harder) {
                if (!learns(job_)) audit_effort_ *= kHarderLook;
                continue;
            }
            if (finest || result_.looks > kPredictedLooks) {
                settings.least_grid = std::min(settings.leaf_grid, 2 * settings.least_grid);
                settings.least_grid = std::max(kFirstLeastGrid, settings.least_grid);
                audit_effort_ = 1.0;
                audits_.clear();  // what they found is no measure of what is left
            }
            goal = predicted * next_step();
        }
    }

    void reveal_hidden_light(HybridCubemap& cubemap) {
        take(cubemap.render());
        const std::vector<double> found = light_to_reveal(rendered(), result_.earlier_renders);
        if (!found.empty()) cubemap.reveal(found);
    }

    /// Whether what is not met yet is told by the mean of the job's probes alone: neither predicted
    /// nor told by the few draws that this one has.
    bool only_others_tell() const {
        if (!result_.certificate.by_lot) return false;
        for (size_t t = 0; t < result_.met_by.size(); ++t) {
            if (result_.met_by[t] == EvidenceOf::kNone && result_.pooled[t]) return false;
        }
        return true;
    }

    bool may_look_harder() const {
        if (!estimate_meets(job_.quality, result_.certificate.error)) return false;
        return learns(job_) ? rays_left() >= kAuditShare * rays_of_render()
                            : audit_effort_ < kHardestLook;
    }

    double rays_of_render() const { return static_cast<double>(render_.total().all_rays()); }

    /// For the next audit. Where probes learn from each other all audits of one keep to a part of
    /// its render's steps; but where none has told of what is left, the next one does.
    double rays_left() const {
        if (!learns(job_)) return std::numeric_limits<double>::infinity();
        const CostStats render = render_.total();
        const bool told = std::any_of(audits_.begin(), audits_.end(),
                                      [](const AuditedRatio& audit) { return audit.draws > 0; });
        const double part =
            (params_.teaches ? kTeachingAudits : kAudits) + (told ? 0.0 : kLeastTold);
        const double steps =
            part * static_cast<double>(render.steps) - static_cast<double>(audited_.steps);
        return std::max(0.0, steps) / std::max(1.0, steps_per_audit_ray());
    }

    /// By this probe's audits, else by the first probes', else by what was cast so far.
    double steps_per_audit_ray() const {
        if (audited_.all_rays() > 0) return steps_per_ray(audited_);
        if (pilot_.audit_cost.all_rays() > 0) return steps_per_ray(pilot_.audit_cost);
        return std::max(steps_per_ray(pilot_.search_cost), steps_per_ray(result_.earlier_renders));
    }

    /// By how much the prediction has to fall for the bound to meet the target.
    double next_step() const {
        const bool all = job_.quality.require == Require::kAll;
        std::optional<double> step;
        for (size_t t = 0; t < job_.quality.targets.size(); ++t) {
            const QualityTarget& target = job_.quality.targets[t];
            const std::optional<double> bound = upper_bound(t);
            if (!bound) continue;
            const double its = kNextAim * *largest_size(target) / *bound;
            step = !step ? its : (all ? std::min(*step, its) : std::max(*step, its));
        }
        return std::clamp(step.value_or(kSmallestStep), kSmallestStep, kLargestStep);
    }

    /// The upper bound of a target's error that the next look has to bring down.
    std::optional<double> upper_bound(size_t t) const {
        if (result_.pooled[t]) return result_.pooled[t]->upper;
        const auto size = error_size(job_.quality.targets[t].metric, result_.certificate.error);
        if (!size) return std::nullopt;
        return size->interval(result_.confidence).high;
    }

    /// Renders by other renderers, one finer than the other.
    void render_until_good() {
        result_.settings = pilot_.settings;
        if (params_.out_of_time) {
            result_.settings = through_media()
                                   ? RenderSettings{.kind = RendererKind::kPaths, .samples = 2}
                                   : RenderSettings{.kind = RendererKind::kLod};
        }
        size_t next = 0;
        take(render());
        while (const std::optional<size_t> finer = finer_by_variances(next)) {
            render_again(*finer);
            next = *finer + 1;
        }
        while (audits()) {
            look();
            if (result_.target_met || only_others_tell() || !may_look_again()) return;
            if (as_good_as_met()) {
                if (may_be_pooled()) return;
                audit_effort_ *= kHarderLook;
            } else {
                if (next == pilot_.finer.size()) return;
                if (!affords_another_render()) {
                    render_.limited = true;
                    return;
                }
                next = next_finer(next, result_.certificate.error);
                render_again(next++);
            }
            ++result_.looks;
        }
    }

    void render_again(size_t finer) {
        result_.earlier_renders += render_.total();
        render_mse_ = pilot_.finer[finer].mse;
        result_.settings = pilot_.finer[finer].settings;
        take(render());
    }

    /// The settings from `next` on whose pixels' variances lead to expect what is asked for, where
    /// those of the render do not.
    std::optional<size_t> finer_by_variances(size_t next) const {
        const bool any_will_do =
            job_.quality.targets.size() > 1 && job_.quality.require == Require::kAny;
        if (!told_by_variances() || any_will_do || params_.out_of_time || render_.limited ||
            next == pilot_.finer.size() || !affords_another_render()) {
            return std::nullopt;
        }
        std::optional<size_t> finer;
        for (size_t t = 0; t < pilot_.steering.size(); ++t) {
            if (!pilot_.steering[t]) continue;
            const double step =
                rendered().noise().step(job_.quality.targets[t], *pilot_.steering[t]);
            if (step >= 1.0) continue;
            finer = std::max(finer.value_or(next), finer_than(next, render_mse_ * step));
        }
        return finer;
    }

    /// The first settings from `next` on that leave at most this error, or the finest.
    size_t finer_than(size_t next, double mse) const {
        while (next + 1 < pilot_.finer.size() && pilot_.finer[next].mse > mse) ++next;
        return next;
    }

    bool as_good_as_met() const {
        return rendered().leaf_rays_only() &&
               bound_meets(job_.quality, result_.certificate.error, kLeafRaysConfidence);
    }
    /// Where the mean of all probes may speak for a probe, it need not be sure itself.
    bool may_be_pooled() const { return learns(job_); }

    bool may_look_again() const {
        return !params_.out_of_time && !render_.limited &&
               pilot_.expectation == Expectation::kTargetMet &&
               !only_target(job_.quality, QualityTarget::Metric::kRays) &&
               result_.looks < kMaxLooks;
    }

    /// The first finer candidate that promises to make up for what the look found missing.
    size_t next_finer(size_t next, const MeasuredError& found) const {
        const QualityTarget& target = job_.quality.targets.front();
        double allowed = 0.0;
        double high = 0.0;
        if (result_.pooled.front()) {
            allowed = *largest_size(target);
            high = result_.pooled.front()->upper;
        } else if (target.metric == QualityTarget::Metric::kIrradianceRel) {
            const double bound = found.irradiance->interval(result_.confidence).high;
            allowed = largest_square(target);
            high = bound * bound;
        } else if (const auto size = error_size(target.metric, found);
                   size && target.metric != QualityTarget::Metric::kSsim) {
            allowed = *largest_size(target);
            high = size->interval(result_.confidence).high;
        } else {
            return next;
        }
        if (std::isinf(high)) return next;  // of a black file: how much finer is not known
        return finer_than(next, render_mse_ * allowed / high);
    }

    bool through_media() const { return pilot_.media != nullptr; }

    bool told_by_variances() const { return through_media() || rendered().irradiance_by_noise(); }

    RenderedProbe rendered() const {
        return {.scene = scene_,
                .job = job_,
                .pilot = pilot_,
                .probe = params_.probe,
                .render_scene = render_scene_,
                .render = render_,
                .as_written = as_written_,
                .settings = result_.settings,
                .mse = render_mse_};
    }

    CubemapRender render() const {
        const std::optional<uint64_t> limit = ray_limit(job_, probe_);
        if (through_media()) {
            return render_through_media(scene_, *pilot_.media->tracer, rendered().paths_view(),
                                        result_.settings, {limit, seconds_left()}, cancel_);
        }
        return render_cubemap(render_scene_, origin_, probe_.face_size_px, result_.settings,
                              cancel_, limit);
    }

    /// For one render more.
    std::optional<double> seconds_left() const {
        if (!params_.seconds) return std::nullopt;
        return kRenderShareOfTime * *params_.seconds - result_.earlier_renders.seconds -
               result_.decision_cost.seconds - result_.certificate.cost.seconds;
    }
    /// With less time than the last one took, another would be worse.
    bool affords_another_render() const {
        return !seconds_left() || *seconds_left() > 2.0 * render_.total().seconds;
    }

    void take(CubemapRender render) {
        render_ = std::move(render);
        as_written_ = rounded_to_file(render_.color);
    }

    /// Audits what there is on fresh pixels and judges it.
    void look() {
        result_.decision_cost += result_.certificate.cost;
        result_.certificate = audit_probe(rendered(),
                                          {.number = result_.looks,
                                           .effort = audit_effort_,
                                           .most_rays = rays_left(),
                                           .teaches = params_.teaches && result_.looks == 1},
                                          cancel_);
        audited_ += result_.certificate.cost;
        const double doubt = 1.0 - job_.quality.evidence.confidence;
        result_.confidence = 1.0 - std::ldexp(doubt, 1 - result_.looks);
        const std::vector<QualityTarget>& targets = job_.quality.targets;
        result_.pooled.assign(targets.size(), std::nullopt);
        audits_.resize(targets.size());
        std::vector<EvidenceOf>& evidence = result_.met_by;
        evidence.clear();
        for (size_t t = 0; t < targets.size(); ++t) evidence.push_back(look_at(t));
        result_.target_met = targets_meet(job_.quality, [&](const QualityTarget& target) {
            return evidence[static_cast<size_t>(&target - targets.data())] != EvidenceOf::kNone;
        });
        const bool of_job =
            std::find(evidence.begin(), evidence.end(), EvidenceOf::kJob) != evidence.end();
        result_.evidence = result_.target_met && of_job ? EvidenceOf::kJob : EvidenceOf::kProbe;
    }

    /// Few rays that all saw the same make some probes of a job much worse than predicted: what
    /// the job tells of that does not hold where there are more in every pixel.
    ErrorPrior prior_of(size_t t) const {
        const ErrorPrior& of_job = pilot_.steering[t]->prior;
        const bool many_rays = result_.settings.least_grid >= kFirstLeastGrid;
        if (!many_rays || !is_of_squares(job_.quality.targets[t].metric)) return of_job;
        ErrorPrior usual = kUsualPrior;
        usual.ratio = std::min(usual.ratio, of_job.ratio);
        return usual;
    }

    /// Whose evidence says that a target is met; none where it is not.
    EvidenceOf look_at(size_t t) {
        const QualityTarget& target = job_.quality.targets[t];
        const MeasuredError& error = result_.certificate.error;
        std::optional<AuditedRatio> ratio;
        if (!pilot_.steering.empty() && pilot_.steering[t]) {
            ratio = audited_ratio(target.metric, result_.certificate);
        }
        if (result_.looks == 1) result_.first_look.push_back(ratio);
        const bool own_meets = bound_meets(target, error, result_.confidence);
        if (!ratio) return own_meets ? EvidenceOf::kProbe : EvidenceOf::kNone;
        const double allowed = *largest_size(target);
        const ErrorPrior prior = prior_of(t);
        audits_[t] = with_further_audit(audits_[t], *ratio);
        const PooledError pooled =
            pooled_error(prior, audits_[t], job_.quality.evidence.confidence);
        result_.pooled[t] = pooled;
        const EvidenceOf of_job = pooled.upper <= allowed ? EvidenceOf::kJob : EvidenceOf::kNone;
        if (ratio->draws == 0) return of_job;
        const bool tells =
            static_cast<double>(ratio->draws) >= kTellingDraws * prior.draw_cv * prior.draw_cv;
        // Where it tells that the probe is unlike the others of its job, it alone counts.
        const Interval own = error_size(target.metric, error)->interval(result_.confidence);
        if (tells && !(pooled.value >= own.low && pooled.value <= own.high)) {
            result_.pooled[t].reset();
        }
        if (tells && own_meets) return EvidenceOf::kProbe;
        return result_.pooled[t] && own.low <= allowed ? of_job : EvidenceOf::kNone;
    }

    const Scene& scene_;
    const JobSpec& job_;
    const Pilot& pilot_;
    const UnitParams& params_;
    const ProbeSpec& probe_;
    const CancelToken& cancel_;
    RenderScene render_scene_;
    Vec3 origin_;
    CubemapRender render_;
    Cubemap as_written_;
    double render_mse_;                 // what the pilot found for the settings of the render
    std::vector<AuditedRatio> audits_;  // all of this probe, one per target
    double audit_effort_ = 1.0;
    CostStats audited_;  // in all looks
    ProbeResult result_;
};

}  // namespace

ProbeResult bake_probe(const Scene& scene, const JobSpec& job, const Pilot& pilot,
                       const UnitParams& unit, const CancelToken& cancel) {
    return Unit(scene, job, pilot, unit, cancel).run();
}

}  // namespace probebake
