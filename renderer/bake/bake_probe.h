// One work unit: one probe in one lighting state, rendered, audited and encoded.
//
// bake_probe is a pure function of its arguments: the same bytes from any thread, process or
// machine of the class. It is rendered, audited, and refined and audited again on fresh pixels
// until the upper bound of its error meets the target. The audit of the last look is the
// certificate. The bound is
//   that of this audit alone, where it is large enough to tell: look k bounds with a confidence of
//   1 − (1 − c) · 2^−k, c being the job's, so that all looks together are wrong as often as c
//   allows, however often one looks (Bonferroni);
//   else the one of error_prior.h, which knows all audits of the probe and of others of the job.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bake/audit.h"
#include "bake/ddgi.h"
#include "bake/pilot.h"

namespace probebake {

/// Whose evidence a verdict stands on.
enum class EvidenceOf {
    kNone,
    kProbe,  // the probe's own audit tells
    kJob,    // it is too small to tell; together with those of the job it does
};

std::string_view name_of(EvidenceOf evidence);

struct ProbeResult {
    size_t probe = 0;  // index into JobSpec::probes
    LightingState state;
    RenderSettings settings;  // of the render that is in the files
    std::array<CostStats, kFaceCount> faces;
    std::array<uint64_t, kFaceCount> pixels{};
    bool limited = false;       // by a ray limit, or out of time
    int looks = 1;              // renders, the last of them in the files
    CostStats earlier_renders;  // of the looks before, as far as they were not refined further
    Audit certificate;          // of the last look; empty without audit
    double confidence = 0.0;    // of its intervals, two-sided
    bool target_met = false;    // by its bound
    EvidenceOf evidence = EvidenceOf::kNone;
    /// Its error with what the job knows, in the target's size (error_size), one per target; at the
    /// job's confidence.
    std::vector<std::optional<PooledError>> pooled;
    /// First looks, one per target, for the priors of further probes.
    std::vector<std::optional<AuditedRatio>> first_look;
    CostStats decision_cost;  // of the audits of looks before
    bool is_float = false;    // a value of a file did not fit into HALF
    bool inside_voxel = false;
    double far_m = 0.0;  // effective
    double wall_seconds = 0.0;
    std::vector<ProductFile> files;
    std::optional<DdgiTile> ddgi;  // where that is a product

    CostStats render_cost() const;
};

/// What is known of a probe's squared error: with the job's other audits where they were asked.
ErrorFigures error_figures(const QualitySpec& quality, const ProbeResult& result);

/// What the engine decides for a unit.
struct UnitParams {
    size_t probe = 0;
    /// The job's wall time is used up: the cheapest settings, no second look.
    bool out_of_time = false;
    /// Whether further probes learn from this one's audit, which then is a larger one.
    bool teaches = false;
};

/// How many probes, from the first, are baked before the others so that these can learn from their
/// audits; 0 where it does not pay.
size_t probes_to_learn_from(const JobSpec& job);

/// What the first probes of a state have shown of how predictions and errors compare: for the
/// pilot that further probes are baked with.
void learn(Pilot& pilot, const QualitySpec& quality, std::span<const ProbeResult> first);

/// Throws Cancelled.
ProbeResult bake_probe(const Scene& scene, const JobSpec& job, const Pilot& pilot,
                       const UnitParams& unit, const CancelToken& cancel);

}  // namespace probebake
