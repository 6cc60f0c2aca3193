// What a work unit leaves: its files, what they cost, how wrong they are and how that is known.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bake/audit.h"
#include "bake/ddgi.h"
#include "bake/error_prior.h"

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
    bool limited = false;  // by a ray limit, or out of time
    int looks = 1;         // audits, the last of them of what is in the files
    /// Of what is not in them: replaced, not refined further; and rays to hidden light.
    CostStats earlier_renders;
    Audit certificate;        // of the last look; empty without audit, and where it was spared
    double confidence = 0.0;  // of its own intervals, two-sided; from the second look on above
                              // the job's, which is what rows and files promise
    bool target_met = false;  // by its bound
    EvidenceOf evidence = EvidenceOf::kNone;
    /// Whose evidence says that a target is met, one per target; none where it is not.
    std::vector<EvidenceOf> met_by;
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
    /// Whether anything is known of its error: by its own audit, or by those of others.
    bool audited() const;
};

ErrorFigures figures_of(const PooledError& square);
/// What is known of a probe's squared error: with the job's other audits where they were asked.
/// None where nothing is: no audit, or one that was spared and other metrics are the targets.
std::optional<ErrorFigures> error_figures(const QualitySpec& quality, const ProbeResult& result);

}  // namespace probebake
