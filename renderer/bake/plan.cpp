#include "bake/plan.h"

#include <algorithm>

#include "bake/ddgi.h"
#include "bake/job_names.h"
#include "bake/job_size.h"
#include "bake/state_light.h"
#include "image/cubemap.h"
#include "image/sphere_filter.h"
#include "render/render.h"

namespace probebake {
namespace {

/// Sums of a pixel's paths and what is made of them (volume_cubemap.cpp).
constexpr uint64_t kPathBytesPerTexel = 128;

/// Everything of a job that no state, product or target asks for.
std::vector<LeftOut> unneeded(const Scene& scene, const JobSpec& job, const Plan& plan) {
    std::vector<LeftOut> out;
    const auto leave = [&](std::string what, const char* why) {
        out.push_back({std::move(what), why});
    };
    const bool emission_asked =
        std::any_of(job.states.begin(), job.states.end(), [](const LightingState& state) {
            return state.kind == LightingState::Kind::kEmission || (state.lit() && state.emission);
        });
    const bool lit = std::any_of(job.states.begin(), job.states.end(),
                                 [](const LightingState& state) { return state.lit(); });
    if (!lit) leave("lighting", "no lighting state has sun or sky");
    if (!scene.emits()) {
        leave("emission colours", "no voxel of the scene emits");
    } else if (!emission_asked) {
        leave("emission colours", "no lighting state shows emission");
    }
    if (scene.media.empty()) {
        leave("paths through media", "the scene has no media");
    } else if (!plan.media) {
        leave("paths through media", "albedo is reflectance: media have none");
    } else {
        leave("light per face", "paths meet sun and sky by themselves");
        for (const std::string& text : plan.media->choice.left_out) {
            const size_t colon = text.find(": ");
            out.push_back({text.substr(0, colon), text.substr(colon + 2)});
        }
    }
    if (scene.surface.empty()) {
        leave("object octree", scene.mesh ? "all surfaces of the mesh have two fronts, or holes"
                                          : "the scene has no mesh");
    } else if (!plan.needs_object_octree) {
        leave("object octree", "the mesh has become voxels; only validity would ask its triangles");
    }
    if (!plan.needs_error_table) leave("error table", "no renderer of this job looks at it");
    if (plan.leaf_rays_only) {
        leave("quality search", "irradiance begins with one ray per pixel: nothing is cheaper");
        leave("refinement ladder",
              "the target is irradiance: errors of single pixels average out over the sphere");
        leave("LOD colours", "leaf rays show voxels");
    } else if (!plan.needs_pilot) {
        leave("quality search", "the job brings its own settings");
    }
    if (!plan.needs_audit) leave("audit", "the job asks for no evidence");
    for (size_t i = 0; i < kProductNames.size(); ++i) {
        if (job.products.*kProductFlags[i]) continue;
        leave(std::string(kProductNames[i]) + " file", "products do not name it");
    }
    if (!has_target(job.quality, QualityTarget::Metric::kSsim)) {
        leave("SSIM audit", "the target is another metric; SSIM costs whole windows of pixels");
    }
    return out;
}

/// What the hybrid renderer keeps of a pixel between two refinements (hybrid_view.h).
constexpr uint64_t kKeptPixelBytes = 260;

/// Cheapest first.
std::vector<RendererKind> renderers_of(const JobSpec& job) {
    if (wants_leaf_rays_only(job)) return {RendererKind::kReference};
    if (job.quality.renderer) return {*job.quality.renderer};
    // The hybrid's colours are nearer to the truth than 4 × 4 leaf rays are: not what a job wants
    // that measures against these.
    if (job.quality.against == Against::kTruth) return {RendererKind::kHybrid};
    return {RendererKind::kErrorAware, RendererKind::kReference};
}

/// Of all files together, uncompressed; a latlong has 8 N² pixels where a cube has 6 N².
uint64_t bytes_per_texel(const Products& products) {
    constexpr uint64_t kHalfRgb = 6;
    uint64_t bytes = 0;
    if (products.cube) bytes += kHalfRgb;
    if (products.aux) bytes += 6 * sizeof(float);
    if (products.latlong) bytes += kHalfRgb * 4 / 3;
    if (products.gl_faces) bytes += kHalfRgb;
    if (products.specular) bytes += kHalfRgb * 4 / 3;
    return bytes;
}

void check_memory(const JobSpec& job, const Plan& plan) {
    if (!job.budget.memory_bytes) return;
    const uint64_t bytes = plan.scene_bytes + plan.light_bytes + plan.bytes_per_unit;
    if (bytes <= *job.budget.memory_bytes) return;
    throw SpecError(SpecError::Kind::kUnacceptable, "/budget/memory_bytes",
                    "scene, light and one cubemap at work take " + std::to_string(bytes) +
                        " bytes, expected at most " + std::to_string(*job.budget.memory_bytes));
}

}  // namespace

JobSize size_of_job(const JobSpec& job) {
    JobSize size;
    int largest = 0;
    for (const ProbeSpec& probe : job.probes) largest = std::max(largest, probe.face_size_px);
    size.unit_texels = 6 * static_cast<uint64_t>(largest) * static_cast<uint64_t>(largest);
    const uint64_t unit_texels = size.unit_texels;
    // The render (twice while faces become a cube), the values as written, and the encoded files.
    size.unit_bytes =
        unit_texels *
        (2 * (sizeof(Rgb) + sizeof(PixelAux)) + sizeof(Rgb) + 3 * sizeof(float) +
         (renderers_of(job).front() == RendererKind::kHybrid ? kKeptPixelBytes : 0) +
         (job.products.aux ? 6 * sizeof(float) : 0) + (job.products.latlong ? 2 * sizeof(Rgb) : 0));
    if (job.products.specular || job.products.ddgi) {
        size.unit_bytes += SphereFilter::memory_bytes(largest);
    }
    if (job.products.specular) size.unit_bytes += unit_texels * sizeof(Rgb);
    if (job.products.ddgi) size.unit_bytes += unit_texels * sizeof(Rgb);
    const uint64_t units = job.probes.size() * job.states.size();
    size.output_bytes = texel_count(job) * bytes_per_texel(job.products) + units * 16384;
    if (job.products.ddgi) size.output_bytes += units * kDdgiBytesPerProbe;
    return size;
}

Plan make_plan(const Scene& scene, const JobSpec& job) {
    Plan plan;
    plan.leaf_rays_only = wants_leaf_rays_only(job);
    plan.renderers = renderers_of(job);
    plan.needs_error_table = plan.renderers.front() == RendererKind::kErrorAware ||
                             plan.renderers.front() == RendererKind::kHybrid;
    plan.needs_pilot = !job.quality.settings && !plan.leaf_rays_only;
    plan.needs_audit = job.quality.evidence.audit;
    const bool through_media =
        std::any_of(job.states.begin(), job.states.end(),
                    [&](const LightingState& state) { return sees_media(scene, state); });
    if (through_media) {
        plan.media = plan_media(scene, job);
    } else if (job.quality.tracker) {
        throw SpecError(SpecError::Kind::kUnacceptable, "/quality/tracker",
                        scene.media.empty()
                            ? "the scene has no media that a tracker could fly through"
                            : "no state of this job is seen through media");
    }
    plan.needs_object_octree = job.validity && !scene.surface.empty();
    plan.left_out = unneeded(scene, job, plan);
    plan.work_units = job.probes.size() * job.states.size();
    plan.texels = texel_count(job);
    plan.scene_bytes = scene.memory_bytes();
    for (size_t i = 0; i < job.states.size(); ++i) check_sky_file(scene, job, i);
    plan.light_bytes = expected_light_bytes(scene, job);

    const JobSize size = size_of_job(job);
    plan.bytes_per_unit = size.unit_bytes;
    if (plan.media) plan.bytes_per_unit += size.unit_texels * kPathBytesPerTexel;
    plan.output_bytes = size.output_bytes;

    check_memory(job, plan);

    if (scene.tree.empty()) plan.warnings.emplace_back("the scene holds no voxels");
    uint64_t inside = 0;
    uint64_t invalid = 0;
    for (const ProbeSpec& probe : job.probes) {
        if (scene.inside_voxel(probe.position_m)) ++inside;
        if (probe.place && !probe.place->valid) ++invalid;
    }
    if (inside > 0) {
        plan.warnings.push_back(std::to_string(inside) +
                                " probes lie in a voxel, which their rays pass through");
    }
    if (invalid > 0) {
        plan.warnings.push_back(std::to_string(invalid) +
                                " probes stand in places that are invalid (their rows say why)");
    }
    for (const Medium& medium : scene.media.all()) {
        const auto* shape = std::get_if<HomogeneousShape>(&medium.spec.shape);
        if (!plan.media || shape == nullptr || shape->box_m) continue;
        plan.warnings.push_back("medium '" + medium.spec.name +
                                "' never ends: no light of sun or sky comes through it");
    }
    for (const std::string& warning : scene.warnings) plan.warnings.push_back(warning);
    return plan;
}

Json write_plan(const Plan& plan) {
    Json json = {{"work_units", plan.work_units},
                 {"texels", plan.texels},
                 {"quality_search", plan.needs_pilot},
                 {"audit", plan.needs_audit},
                 {"object_octree", plan.needs_object_octree},
                 {"memory",
                  {{"scene_bytes", plan.scene_bytes},
                   {"light_bytes", plan.light_bytes},
                   {"bytes_per_work_unit", plan.bytes_per_unit},
                   {"total_bytes", plan.scene_bytes + plan.light_bytes + plan.bytes_per_unit}}},
                 {"output_bytes_at_most", plan.output_bytes},
                 {"left_out", Json::array()},
                 {"warnings", plan.warnings}};
    for (const RendererKind kind : plan.renderers) json["renderers"].push_back(name_of(kind));
    if (plan.media) {
        json["media"] = {{"tracker", name_of(plan.media->choice.tracker)},
                         {"transmittance", name_of(plan.media->choice.transmittance)},
                         {"reason", plan.media->choice.reason},
                         {"media", plan.media->media},
                         {"bytes", plan.media->bytes}};
        if (!plan.media->emitters.empty()) json["media"]["emissive_voxels"] = plan.media->emitters;
    }
    for (const LeftOut& left : plan.left_out) {
        json["left_out"].push_back({{"what", left.what}, {"why", left.why}});
    }
    return json;
}

}  // namespace probebake
