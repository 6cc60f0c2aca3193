#include "bake/probe_files.h"

#include <cmath>

#include "bake/sh_file.h"
#include "image/exr.h"
#include "image/layouts.h"
#include "image/specular.h"

namespace probebake {
namespace {

class FileMaker {
  public:
    FileMaker(const RenderedProbe& what, ProbeResult& result)
        : what_(what), probe_(what.job.probes[result.probe]), result_(result) {}

    void encode() {
        const ProbeAttributes attributes = this->attributes();
        if (what_.job.products.cube) {
            add_cubemap("cube.exr", encode_cubemap(what_.render.color, attributes));
        }
        if (what_.job.products.latlong) {
            add_cubemap("latlong.exr", encode_layout(latlong_of(what_.render.color),
                                                     ExrLayout::kLatlong, attributes));
        }
        for (const CubeFace face : kCubeFaces) {
            if (!what_.job.products.gl_faces) break;
            add_cubemap(
                std::string(kGlFaceNames[static_cast<size_t>(index_of(face))]) + ".exr",
                encode_layout(gl_face_of(what_.render.color, face), ExrLayout::kPlain, attributes));
        }
        if (what_.job.products.aux) add_file("aux.exr", encode_aux(aux(), attributes));
        if (what_.job.products.sh) {
            add_file("sh.json", encode_sh({.radiance = project_sh(what_.as_written),
                                           .audit = result_.certificate.sh,
                                           .confidence = what_.job.quality.evidence.confidence,
                                           .look_confidence = result_.confidence,
                                           .expected = expected_irradiance(),
                                           .probe = attributes}));
        }
        if (what_.job.products.specular) add_specular(attributes);
        if (what_.job.products.ddgi) result_.ddgi = ddgi_tile(what_.render.color, near_distances());
    }

  private:
    std::optional<ExpectedIrradiance> expected_irradiance() const {
        const QualitySpec& quality = what_.job.quality;
        const std::optional<IrradianceNoise>& noise = result_.certificate.noise;
        for (size_t t = 0; t < result_.pooled.size(); ++t) {
            if (quality.targets[t].metric == QualityTarget::Metric::kIrradianceRel && noise &&
                result_.pooled[t]) {
                return ExpectedIrradiance{*noise, *result_.pooled[t]};
            }
        }
        return std::nullopt;
    }

    ProbeAttributes attributes() const {
        ProbeAttributes out = state_attributes(what_.scene, what_.job, what_.pilot.state);
        out.id = probe_.id;
        out.position_m = probe_.position_m;
        out.near_m = probe_.near_m;
        out.far_m = result_.far_m;
        out.valid = !result_.inside_voxel;
        if (probe_.place) add_place(*probe_.place, out);
        if (const auto figures = error_figures(what_.job.quality, result_)) {
            add_errors(*figures, out);
        }
        return out;
    }

    void add_place(const ProbePlace& place, ProbeAttributes& out) const {
        out.valid = place.valid;
        if (!what_.job.validity) return;
        out.numbers["probe:closedIn"] = place.closed_in;
        if (place.backface) out.numbers["probe:backface"] = *place.backface;
        if (std::isfinite(place.nearest_surface_m)) {
            out.numbers["probe:nearestSurface"] = place.nearest_surface_m;
        }
        if (place.moved) out.texts["probe:requestedPosition"] = attribute_text(place.requested_m);
    }

    void add_errors(const ErrorFigures& figures, ProbeAttributes& out) const {
        const double confidence = what_.job.quality.evidence.confidence;
        out.texts["probe:err:evidence"] = name_of(result_.evidence);
        out.texts["probe:err:against"] = name_of(what_.job.quality.against);
        out.numbers["probe:err:exposure"] = what_.pilot.exposure;
        out.numbers["probe:err:confidence"] = confidence;
        out.numbers["probe:err:pixels"] = static_cast<double>(result_.certificate.pixels);
        out.numbers["probe:err:rmse"] = figures.rmse;
        out.numbers["probe:err:rmseLow"] = figures.rmse_interval.low;
        out.numbers["probe:err:rmseHigh"] = figures.rmse_interval.high;
    }

    /// One file per mip; the audit's figures are those of the cube, not of these.
    void add_specular(ProbeAttributes attributes) {
        std::erase_if(attributes.texts,
                      [](const auto& item) { return item.first.starts_with("probe:err:"); });
        std::erase_if(attributes.numbers,
                      [](const auto& item) { return item.first.starts_with("probe:err:"); });
        const int n = probe_.face_size_px;
        const int mips = specular_mips(n);
        attributes.numbers["probe:specular:mips"] = mips;
        std::optional<SphereFilter> filter;
        if (mips > 1) filter.emplace(what_.render.color);
        for (int mip = 0; mip < mips; ++mip) {
            const double roughness = specular_roughness(mip, mips);
            attributes.numbers["probe:specular:mip"] = mip;
            attributes.numbers["probe:specular:roughness"] = roughness;
            const Cubemap cube = mip == 0 ? what_.render.color
                                          : specular_of(*filter, roughness * roughness, n >> mip);
            add_cubemap("specular-" + std::to_string(mip) + ".exr",
                        encode_cubemap(cube, attributes));
        }
    }

    /// Means and mean squares for ddgi_tile.
    Cubemap near_distances() const {
        Cubemap distances(probe_.face_size_px);
        const double metre = what_.scene.voxel_size_m;
        for (size_t i = 0; i < what_.render.aux.size(); ++i) {
            const PixelAux& pixel = what_.render.aux[i];
            distances.image().pixels()[i] = Rgb(Vec3(
                pixel.near_distance * metre, pixel.squared_near_distance * metre * metre, 0.0));
        }
        return distances;
    }

    CubeAux aux() const {
        CubeAux aux{.face_size = probe_.face_size_px};
        const double metre = what_.scene.voxel_size_m;
        for (const PixelAux& pixel : what_.render.aux) {
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
        result_.files.push_back(make_product_file(std::move(name), std::move(bytes)));
    }

    const RenderedProbe& what_;
    const ProbeSpec& probe_;
    ProbeResult& result_;
};

}  // namespace

void make_files(const RenderedProbe& what, ProbeResult& result) {
    FileMaker(what, result).encode();
}

ProbeAttributes state_attributes(const Scene& scene, const JobSpec& job, const ReadyState& state) {
    ProbeAttributes out;
    out.owner = "probebake " PROBEBAKE_VERSION;
    out.state = name_of(state.spec);
    out.unit = state.spec.kind == LightingState::Kind::kAlbedo ? "1" : "W.m^-2.sr^-1";
    out.scene_sha256 = scene.sha256;
    out.seed = job.seed;
    if (state.light != nullptr && !state.light->sky_sha256.empty()) {
        out.texts["probe:skySha256"] = state.light->sky_sha256;
    }
    return out;
}

}  // namespace probebake
