// JobSpec: what a client asks for, checked, with every default filled in.
//
// read_job turns the JSON of a request into a JobSpec or throws a SpecError that names every
// problem by its JSON pointer; write_job gives back the request as it was understood (the report's
// `effective_request`). docs/request.md documents the fields.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bake/lighting_state.h"
#include "image/metrics.h"
#include "io/json.h"
#include "render/render_settings.h"
#include "scene/probe_place.h"
#include "track/choice.h"

namespace probebake {

struct ProbeSpec {
    std::string id;
    Vec3 position_m{0.0};
    int face_size_px = 64;
    double near_m = 0.0;          // nearer hits are passed through
    std::optional<double> far_m;  // farther hits are misses; none: the whole world is seen
    /// None of the request: once it was looked at (probe_places.h).
    std::optional<ProbePlace> place;
};

/// A regular grid of probes: (i, j, k) stands at origin + spacing · (i, j, k) and is the probe of
/// index first_probe + i + counts.x (j + counts.y k), called {id}-{i}-{j}-{k}.
struct ProbeGrid {
    std::string id;
    Vec3 origin_m{0.0};
    Vec3 spacing_m{0.0};
    IVec3 counts{1};
    size_t first_probe = 0;

    size_t size() const {
        return static_cast<size_t>(counts.x) * static_cast<size_t>(counts.y) *
               static_cast<size_t>(counts.z);
    }
};

/// A quality target of a job.
struct QualityTarget {
    enum class Metric {
        kPsnrDb,
        kRmse,
        kSsim,
        kRays,           // per probe and state
        kIrradianceRel,  // ‖A_l ΔL_lm‖ / ‖A_l L_lm‖ (sh_audit.h)
        kRelMse,         // squared errors over squared values (metrics.h)
    };
    Metric metric = Metric::kPsnrDb;
    double value = 40.0;
};

/// Which of several targets have to be met.
enum class Require { kAll, kAny };

/// The target of a job that names none and whose only product are spherical harmonics.
inline constexpr double kDefaultIrradianceRel = 0.05;

/// What an image is measured against.
enum class Against {
    kTruth,      // the mean leaf-level radiance over a pixel's footprint
    kReference,  // the thesis's 4 × 4 leaf rays
};

struct EvidenceSpec {
    bool audit = true;
    /// Audited pixels per probe and state; none: as many as a share of the render pays for.
    std::optional<int> pixels_per_probe;
    double confidence = 0.95;
};

struct QualitySpec {
    std::vector<QualityTarget> targets = {QualityTarget{}};  // at least one; rays only alone
    Require require = Require::kAll;
    /// None: the plan chooses.
    std::optional<RendererKind> renderer;
    /// Of paths through media. None: the plan's rule and the pilot choose.
    std::optional<TrackerKind> tracker;
    /// Settings of the client's own: nothing is searched, the target only judges the outcome.
    std::optional<RenderSettings> settings;
    Against against = Against::kTruth;
    EvidenceSpec evidence;
    /// Images are divided by it before they are compared; none: from the pilot (exposure.h).
    std::optional<double> exposure;
    Weighting weighting = Weighting::kUniform;
};

/// What is asked of the places of probes; a job that asks nothing is told what voxels know.
struct ValiditySpec {
    PlaceRules rules;
    bool relocate = false;      // of grids, by at most kMostCellShare of the cell
    double max_offset_m = 0.0;  // of probes of the list, per axis
};

struct BudgetSpec {
    std::optional<uint64_t> rays;   // rendered rays of the whole job
    std::optional<double> seconds;  // wall clock; makes the result depend on the machine
    /// Of scene, light and one cubemap at work, as planned: jobs that take more are refused.
    std::optional<uint64_t> memory_bytes;
};

/// What a job is in the end whose probes were kept from their targets by a budget of rays or
/// seconds: done, with the best that could be had, or failed, with the same files.
enum class OnBudgetExhausted { kReturnBest, kFail };

/// The files of every probe and state; at least one.
struct Products {
    bool cube = true;
    bool aux = false;
    bool latlong = false;
    bool gl_faces = false;
    bool sh = false;
    bool specular = false;
    bool ddgi = false;  // of grids
};

struct JobSpec {
    std::string scene;
    std::vector<LightingState> states = {LightingState::kAlbedo};
    std::vector<ProbeSpec> probes;  // those of the list, then those of the grids
    std::vector<ProbeGrid> grids;
    QualitySpec quality;
    BudgetSpec budget;
    OnBudgetExhausted on_budget_exhausted = OnBudgetExhausted::kReturnBest;
    Products products;
    std::optional<ValiditySpec> validity;
    uint64_t seed = 1;
    int priority = 0;  // among the waiting jobs of one client: higher ones first
};

/// What a job may ask for at most; checked before anything is allocated.
struct JobLimits {
    uint64_t max_probes = 65'536;
    int min_face_size_px = 1;
    int max_face_size_px = 4096;
    uint64_t max_texels = uint64_t{1} << 32;  // over all probes and states
    double max_position_m = 1e6;              // per axis
    int max_audit_pixels = 65'536;            // per probe
    uint64_t max_states = 16;
    uint64_t max_rays = uint64_t{1} << 50;
    uint64_t max_memory_bytes = uint64_t{1} << 50;
    int max_priority = 100;     // and least, with a minus
    int max_atlas_px = 16'384;  // per side, of ddgi: what Direct3D 12 can load
};

/// Throws SpecError. Knows nothing of scenes: whether the named one exists is the caller's
/// question.
JobSpec read_job(const Json& request, const JobLimits& limits = {});
Json write_job(const JobSpec& spec);

/// Rays (of paths: paths) that a probe may cast in one state, from the target and the budget; none:
/// as many as its settings ask for.
std::optional<uint64_t> ray_limit(const JobSpec& spec, const ProbeSpec& probe);

/// Whether the job wants irradiance and leaves the way there to us: leaf rays, one per pixel to
/// begin with, whose errors average out over the sphere.
bool wants_leaf_rays_only(const JobSpec& spec);

/// The grid that a probe belongs to; null for one of the list.
const ProbeGrid* grid_of(const JobSpec& spec, size_t probe);

std::string_view name_of(QualityTarget::Metric metric);
std::string_view name_of(Against against);

/// Whether the job has a target of this metric, and whether that is its only one.
bool has_target(const QualitySpec& quality, QualityTarget::Metric metric);
bool only_target(const QualitySpec& quality, QualityTarget::Metric metric);

/// A renderer's settings, as requests and reports write them: those that it looks at.
Json write_settings(const RenderSettings& settings);

/// Texels that the job stores, and distinct pixels that it renders, over all probes and states.
uint64_t texel_count(const JobSpec& spec);
uint64_t pixel_count(const JobSpec& spec);

}  // namespace probebake
