#include "bake/bake_probe.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bake/probe_view.h"
#include "bake/sh_file.h"
#include "image/exr.h"
#include "image/layouts.h"
#include "image/ssim.h"
#include "io/sha256.h"

namespace probebake {
namespace {

constexpr int kMaxLooks = 4;
constexpr int kMinAuditPixels = 64;
/// Of a render's rays, what an audit of it may cast.
constexpr double kDecisionShare = 0.02;
constexpr double kCertificateShare = 0.08;
/// Irradiance can only be decided on by a look that sees nearly as sharply as the certificate.
constexpr double kIrradianceDecisionShare = 0.04;
constexpr double kMaxIrradianceDraws = 65'536.0;
constexpr int kMinAuditWindows = 16;
constexpr int kWindowPixels = kSsimWindow_px * kSsimWindow_px;

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
          render_mse_(pilot.settings_mse) {}

    ProbeResult run() {
        const auto start = std::chrono::steady_clock::now();
        result_.probe = params_.probe;
        result_.state = pilot_.state.spec;
        result_.far_m = through_media() ? effective_far_through_media_m(scene_, probe_)
                                        : effective_far_m(scene_, probe_);
        result_.inside_voxel = scene_.inside_voxel(probe_.position_m);
        render_until_good();
        if (job_.quality.evidence.audit) result_.certificate = audit(kCertificate);
        encode();
        result_.wall_seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return std::move(result_);
    }

  private:
    /// Keys of audits: decisions are numbered from 1.
    static constexpr uint64_t kCertificate = 0;

    void render_until_good() {
        result_.settings = pilot_.settings;
        if (params_.out_of_time) {
            result_.settings = through_media()
                                   ? RenderSettings{.kind = RendererKind::kPaths, .samples = 2}
                                   : RenderSettings{.kind = RendererKind::kLod};
        }
        size_t next = 0;
        for (;;) {
            render();
            if (params_.out_of_time || !may_look_again(next)) return;
            const Audit look = audit(static_cast<uint64_t>(result_.looks));
            result_.decision_cost += look.cost;
            if (bound_meets(job_.quality.target, look.error, kLookConfidence)) return;
            next = next_finer(next, look.error);
            result_.earlier_renders += render_.total();
            render_mse_ = pilot_.finer[next].mse;
            result_.settings = pilot_.finer[next++].settings;
            ++result_.looks;
        }
    }

    bool may_look_again(size_t next) const {
        return job_.quality.evidence.audit && !render_.limited &&
               pilot_.expectation == Expectation::kTargetMet &&
               job_.quality.target.metric != QualityTarget::Metric::kRays &&
               result_.looks < kMaxLooks && next < pilot_.finer.size();
    }

    /// The far end of a look's interval, squared.
    double far_square(const MeasuredError& found) const {
        if (!irradiance_target()) return found.mse.interval(kLookConfidence).high;
        const double high = found.irradiance->interval(kLookConfidence).high;
        return high * high;
    }

    bool irradiance_target() const {
        return job_.quality.target.metric == QualityTarget::Metric::kIrradianceRel;
    }

    /// The first finer candidate that promises to make up for what the look found missing.
    size_t next_finer(size_t next, const MeasuredError& found) const {
        if (job_.quality.target.metric == QualityTarget::Metric::kSsim) return next;
        const double wanted = render_mse_ * largest_square(job_.quality.target) / far_square(found);
        while (next + 1 < pilot_.finer.size() && pilot_.finer[next].mse > wanted) {
            ++next;
        }
        return next;
    }

    bool through_media() const { return pilot_.media != nullptr; }

    VolumeView paths_view() const {
        return volume_view(
            scene_, probe_,
            random_key({job_.seed, static_cast<uint64_t>(StreamPurpose::kMediaRender),
                        params_.probe, stream_of(pilot_.state.spec)}));
    }

    void render() {
        const std::optional<uint64_t> limit = ray_limit(job_, probe_);
        render_ = through_media()
                      ? render_through_media(scene_, *pilot_.media->tracer, paths_view(),
                                             result_.settings, limit, cancel_)
                      : render_cubemap(render_scene_, origin_, probe_.face_size_px,
                                       result_.settings, cancel_, limit);
        as_written_ = rounded_to_file(render_.color);
    }

    /// As many paths for each of the two means as the render has in that pixel: the truth then is
    /// about as noisy as the image, where telling is cheapest. For irradiance fewer, as with leaf
    /// rays.
    TruthOf paths_truth() const {
        const double share = irradiance_target() ? 0.6 : 1.0;
        return [this, share, view = paths_view()](const CubePixel& owner, uint64_t key,
                                                  CostStats& stats) {
            const double samples =
                double{render_.aux[cube_index(owner, probe_.face_size_px)].samples};
            return path_truth(*pilot_.media->tracer, view, owner,
                              std::max(1, static_cast<int>(share * samples)), key, stats);
        };
    }

    /// Rays that an audit may cast, in units of what it casts in a pixel with this grid.
    double rays_to_audit(double share) const {
        const auto rays = static_cast<double>(render_.total().all_rays());
        if (!through_media()) return share * rays;
        // A pixel of the audit costs two of the render's.
        return share * static_cast<double>(owned_pixel_count(probe_.face_size_px));
    }

    Audit audit(uint64_t look) const {
        const bool ssim = job_.quality.target.metric == QualityTarget::Metric::kSsim;
        const double decision_share =
            irradiance_target() ? kIrradianceDecisionShare : kDecisionShare;
        const double share = look == kCertificate ? kCertificateShare : decision_share;
        int grid = pilot_.truth_grid;
        if (through_media()) {
            grid = 1;
        } else if (wants_leaf_rays_only(job_)) {
            grid = irradiance_truth_grid(result_.settings.leaf_grid);
        }
        const int pixels =
            audit_pixels(job_.quality, grid, probe_.face_size_px, rays_to_audit(share));
        const AuditSpec spec{
            .truth = through_media() ? paths_truth()
                                     : voxel_truth(render_scene_, origin_, probe_.face_size_px,
                                                   {.against = job_.quality.against, .grid = grid}),
            .as_written = as_written_,
            .aux = render_.aux,
            .exposure = pilot_.exposure,
            .weighting = job_.quality.weighting,
            .pixels = pixels,
            .windows = ssim ? std::max(kMinAuditWindows, pixels / kWindowPixels) : 0,
            .sh = irradiance_target() || job_.products.sh,
            .drawn_for_sh = irradiance_target(),
            .key = random_key({job_.seed, params_.probe, stream_of(pilot_.state.spec), look})};
        return audit_cubemap(spec, cancel_);
    }

    ProbeAttributes attributes() const {
        ProbeAttributes out;
        out.owner = "probebake " PROBEBAKE_VERSION;
        out.id = probe_.id;
        out.state = name_of(pilot_.state.spec);
        out.position_m = probe_.position_m;
        out.near_m = probe_.near_m;
        out.far_m = result_.far_m;
        const bool albedo = pilot_.state.spec.kind == LightingState::Kind::kAlbedo;
        out.unit = albedo ? "1" : "W.m^-2.sr^-1";
        const StateLight* light = pilot_.state.light.get();
        if (light != nullptr && !light->sky_sha256.empty()) {
            out.texts["probe:skySha256"] = light->sky_sha256;
        }
        out.scene_sha256 = scene_.sha256;
        out.seed = job_.seed;
        out.valid = !result_.inside_voxel;
        if (result_.certificate.pixels > 0) add_errors(out);
        return out;
    }

    void add_errors(ProbeAttributes& out) const {
        const double confidence = job_.quality.evidence.confidence;
        const ErrorFigures figures = figures_of(result_.certificate.error.mse, confidence);
        out.texts["probe:err:against"] = name_of(job_.quality.against);
        out.numbers["probe:err:exposure"] = pilot_.exposure;
        out.numbers["probe:err:confidence"] = confidence;
        out.numbers["probe:err:pixels"] = static_cast<double>(result_.certificate.pixels);
        out.numbers["probe:err:rmse"] = figures.rmse;
        out.numbers["probe:err:rmseLow"] = figures.rmse_interval.low;
        out.numbers["probe:err:rmseHigh"] = figures.rmse_interval.high;
    }

    void encode() {
        result_.limited = render_.limited || params_.out_of_time;
        result_.faces = render_.faces;
        result_.pixels = render_.pixels;
        const ProbeAttributes attributes = this->attributes();
        if (job_.products.cube) {
            add_cubemap("cube.exr", encode_cubemap(render_.color, attributes));
        }
        if (job_.products.latlong) {
            add_cubemap("latlong.exr",
                        encode_layout(latlong_of(render_.color), ExrLayout::kLatlong, attributes));
        }
        for (const CubeFace face : kCubeFaces) {
            if (!job_.products.gl_faces) break;
            add_cubemap(
                std::string(kGlFaceNames[static_cast<size_t>(index_of(face))]) + ".exr",
                encode_layout(gl_face_of(render_.color, face), ExrLayout::kPlain, attributes));
        }
        if (job_.products.aux) add_file("aux.exr", encode_aux(aux(), attributes));
        if (job_.products.sh) {
            add_file("sh.json", encode_sh({.radiance = project_sh(as_written_),
                                           .audit = result_.certificate.sh,
                                           .confidence = job_.quality.evidence.confidence,
                                           .probe = attributes}));
        }
    }

    CubeAux aux() const {
        CubeAux aux{.face_size = probe_.face_size_px};
        const double metre = scene_.voxel_size_m;
        for (const PixelAux& pixel : render_.aux) {
            aux.pixels.push_back({static_cast<float>(pixel.distance * metre),
                                  static_cast<float>(pixel.squared_distance * metre * metre),
                                  pixel.standard_error, static_cast<uint32_t>(pixel.samples)});
        }
        return aux;
    }

    void add_cubemap(std::string name, EncodedCubemap file) {
        result_.is_float |= file.is_float;
        add_file(std::move(name), std::move(file.bytes));
    }

    void add_file(std::string name, std::vector<std::byte> bytes) {
        std::string sha256 = sha256_hex(bytes);
        const uint64_t size_bytes = bytes.size();
        result_.files.push_back({std::move(name), std::move(bytes), size_bytes, std::move(sha256)});
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
    double render_mse_;  // what the pilot found for the settings of the render
    ProbeResult result_;
};

}  // namespace

CostStats ProbeResult::render_cost() const {
    CostStats total;
    for (const CostStats& face : faces) total += face;
    return total;
}

ProbeResult bake_probe(const Scene& scene, const JobSpec& job, const Pilot& pilot,
                       const UnitParams& unit, const CancelToken& cancel) {
    return Unit(scene, job, pilot, unit, cancel).run();
}

int audit_pixels(const QualitySpec& quality, int truth_grid, int face_size_px, double rays) {
    if (quality.evidence.pixels_per_probe) return *quality.evidence.pixels_per_probe;
    const double rays_per_pixel =
        quality.against == Against::kReference ? 16.0 : 2.0 * truth_grid * truth_grid;
    const double texels = 6.0 * face_size_px * face_size_px;
    const double paid_for = rays / rays_per_pixel;
    if (quality.target.metric == QualityTarget::Metric::kIrradianceRel) {
        const double most = std::min(texels, kMaxIrradianceDraws);
        const double least = std::min(texels / 100.0, most);
        return std::max(kMinAuditPixels, static_cast<int>(std::clamp(paid_for, least, most)));
    }
    return std::max(kMinAuditPixels,
                    static_cast<int>(std::clamp(paid_for, texels / 100.0, texels / 10.0)));
}

}  // namespace probebake
