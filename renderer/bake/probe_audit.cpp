#include "bake/probe_audit.h"

#include <algorithm>
#include <cmath>

#include "bake/audit_size.h"
#include "bake/hidden_light.h"
#include "bake/learn.h"
#include "bake/probe_view.h"
#include "bake/render_noise.h"

namespace probebake {
namespace {

/// Of a render's rays, what audits cast that others learn from, and those of leaf rays alone.
constexpr double kTeachingShare = 0.2;
constexpr double kLeafRaysShare = 0.1;
/// Through media, for irradiance: of these shares, because audits go where paths are long.
constexpr double kPathsShare = 0.4;
/// Paths of each mean of an audit: so many, squared, at most; in windows at least.
constexpr int kLargestPathGrid = 64;
constexpr int kLeastPathGrid = 2;
/// Of the rays of a render and of an audit, how many more look for hidden light; but at least so
/// many where probes have nothing but their own audit.
constexpr double kHiddenLightShare = 0.25;
constexpr double kLeastHiddenLightRays = 256.0;
/// Of these, those towards emissive voxels: few find them.
constexpr double kEmitterShare = 1.0 / 16.0;
constexpr double kLeastEmitterRays = 64.0;
/// Of an audit's rays, for pixels, where windows decide, too, and where they alone do.
constexpr double kPixelsAndWindows = 0.5;
constexpr double kPixelsBesideWindows = 0.2;
constexpr int kPixelsBesideWindowsAtLeast = 2;

/// Paths through media meet emissive voxels and sky by themselves.
std::vector<double> light_hidden(const RenderedProbe& probe, double rays, double emitter_rays,
                                 uint64_t key, CostStats& cost) {
    if (probe.through_media()) return {};
    return hidden_light({.scene = probe.render_scene,
                         .emitters = probe.pilot.emitters.get(),
                         .origin = probe.scene.to_voxels(probe.spec().position_m),
                         .as_written = probe.as_written,
                         .rays = static_cast<int>(rays),
                         .emitter_rays = static_cast<int>(emitter_rays),
                         .key = key},
                        cost);
}

class ProbeAudit {
  public:
    ProbeAudit(const RenderedProbe& probe, const Look& look)
        : probe_(probe),
          job_(probe.job),
          look_(look),
          rays_(std::min(
              look.most_rays / (1.0 + hidden_light_share()),
              look.effort * share() * static_cast<double>(probe.render.total().all_rays()))),
          key_(random_key({job_.seed, probe.probe, stream_of(probe.pilot.state.spec),
                           static_cast<uint64_t>(look.number)})) {}

    Audit run(const CancelToken& cancel) const {
        const bool irradiance = has_target(job_.quality, QualityTarget::Metric::kIrradianceRel);
        const RenderNoise noise = probe_.noise();
        const DrawBounds draws = bounds(irradiance);
        std::optional<double> ssim_lost;
        if (probe_.through_media() && wants_windows()) ssim_lost = noise.ssim_lost();
        const WindowDraws windows = window_draws(ssim_lost);
        CostStats search_cost;
        const std::vector<double> hidden = look_for_hidden_light(search_cost);
        AuditSpec spec{
            .truth = truth(),
            .as_written = probe_.as_written,
            .aux = probe_.render.aux,
            .hidden = hidden,
            .exposure = probe_.pilot.exposure,
            .largest_radiance = probe_.pilot.largest_radiance,
            .reference_rays = job_.quality.against == Against::kReference,
            .largest_truth_grid = probe_.through_media() ? kLargestPathGrid : kTruthGrids.back(),
            .weighting = job_.quality.weighting,
            .pixels = job_.quality.evidence.pixels_per_probe,
            .rays = pixel_share() * rays_,
            .least_pixels = draws.least,
            .most_pixels = draws.most,
            .lot = by_lot() ? std::optional(lot()) : std::nullopt,
            .windows = windows.count,
            .window_grid = windows.grid,
            .rel_mse = has_target(job_.quality, QualityTarget::Metric::kRelMse),
            .sh = irradiance || job_.products.sh,
            .ssim_lost = ssim_lost,
            .drawn_for_sh = probe_.leaf_rays_only(),
            .key = key_};
        if (irradiance && !probe_.through_media()) spec.truth_grid = truth_grid();
        if (probe_.irradiance_by_noise()) spec.noise = noise.irradiance();
        Audit audit = audit_cubemap(spec, cancel);
        audit.cost += search_cost;
        return audit;
    }

  private:
    bool wants_windows() const { return has_target(job_.quality, QualityTarget::Metric::kSsim); }
    bool windows_alone() const { return only_target(job_.quality, QualityTarget::Metric::kSsim); }

    double share() const {
        if (probe_.leaf_rays_only()) return kLeafRaysShare;
        const double share = look_.teaches && !windows_alone() ? kTeachingShare : kAuditShare;
        return wants_leaf_rays_only(job_) ? kPathsShare * share : share;
    }

    /// Rays to hidden light, per ray of the audit.
    double hidden_light_share() const {
        return !probe_.through_media() &&
                       may_hide_light(probe_.render_scene, probe_.pilot.emitters.get())
                   ? kHiddenLightShare
                   : 0.0;
    }

    /// As much as the audit's share pays for where others of the job are audited, too.
    std::vector<double> look_for_hidden_light(CostStats& cost) const {
        double rays = hidden_light_share() * rays_;
        double emitter_rays = std::min(rays, std::max(kLeastEmitterRays, kEmitterShare * rays));
        if (!learns(job_)) {
            rays = std::max(kLeastHiddenLightRays, rays);
            emitter_rays = std::max(kLeastEmitterRays, kEmitterShare * rays);
        }
        return light_hidden(probe_, rays, emitter_rays, key_, cost);
    }

    /// An audit of a render that took no step costs nothing to speak of.
    bool by_lot() const {
        return learns(job_) && !windows_alone() && probe_.render.total().steps > 0;
    }
    double lot() const {
        return audit_lot(random_key({job_.seed, stream_of(probe_.pilot.state.spec)}), probe_.probe);
    }

    DrawBounds bounds(bool irradiance) const {
        const int n = probe_.spec().face_size_px;
        if (irradiance && !probe_.through_media()) return irradiance_draws(job_, n);
        DrawBounds draws = pixel_draws(job_, n);
        if (windows_alone()) draws.least = kPixelsBesideWindowsAtLeast;
        return draws;
    }

    double pixel_share() const {
        if (windows_alone()) return kPixelsBesideWindows;
        return wants_windows() ? kPixelsAndWindows : 1.0;
    }

    /// Rays per side of each mean where every pixel has the same.
    int truth_grid() const {
        return probe_.leaf_rays_only() ? irradiance_truth_grid(probe_.settings.leaf_grid)
                                       : probe_.pilot.truth_grid;
    }

    /// As many rays per side, or paths in all, as the audit asks for in each of two means.
    TruthOf truth() const {
        if (!probe_.through_media()) {
            return voxel_truth(probe_.render_scene,
                               probe_.scene.to_voxels(probe_.spec().position_m),
                               probe_.spec().face_size_px, job_.quality.against);
        }
        return [this, view = probe_.paths_view()](const CubePixel& owner, int grid, uint64_t key,
                                                  CostStats& stats) {
            return path_truth(*probe_.pilot.media->tracer, view, owner, grid * grid, key, stats);
        };
    }

    /// Through media `lost` is what the noise is expected to take from SSIM.
    WindowDraws window_draws(std::optional<double> lost) const {
        if (!wants_windows()) return {};
        const auto pixels = static_cast<double>(owned_pixel_count(probe_.spec().face_size_px));
        const bool media = probe_.through_media();
        return ssim_windows(
            {.rays_per_pixel = static_cast<double>(probe_.render.total().all_rays()) / pixels,
             .truth_grid = media ? kLargestPathGrid : truth_grid(),
             .least_grid = media ? kLeastPathGrid : 1,
             .of_many = learns(job_),
             .pooled = learns(job_) && !probe_.pilot.steering.empty() && lost != 0.0,
             .teaches = look_.teaches,
             .lot = lot()},
            windows_alone() ? rays_ : (1.0 - kPixelsAndWindows) * rays_);
    }

    const RenderedProbe& probe_;
    const JobSpec& job_;
    Look look_;
    double rays_;
    uint64_t key_;
};

}  // namespace

Audit audit_probe(const RenderedProbe& probe, const Look& look, const CancelToken& cancel) {
    return ProbeAudit(probe, look).run(cancel);
}

std::vector<double> light_to_reveal(const RenderedProbe& probe, CostStats& cost) {
    const auto pixels = static_cast<double>(owned_pixel_count(probe.spec().face_size_px));
    const uint64_t key =
        random_key({probe.job.seed, probe.probe, stream_of(probe.pilot.state.spec)});
    const double least = learns(probe.job) ? 0.0 : kLeastHiddenLightRays;
    const double rays = std::max(least, kHiddenLightShare * pixels);
    return light_hidden(probe, rays, std::max(kLeastEmitterRays, kEmitterShare * rays), key, cost);
}

}  // namespace probebake
