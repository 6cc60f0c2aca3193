// One work unit: one probe in one lighting state, rendered, audited and encoded.
//
// bake_probe is a pure function of its arguments: the same bytes from any thread, process or
// machine of the class. It renders with the pilot's settings; a decision audit on fresh pixels may
// send it back for finer ones, a few times; then a certificate is taken on pixels that decided
// nothing, so that its interval means what it says.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bake/audit.h"
#include "bake/pilot.h"

namespace probebake {

/// A file of a probe, ready to be stored.
struct ProductFile {
    std::string name;  // "cube.exr", "sh.json"
    std::vector<std::byte> bytes;
    uint64_t size_bytes = 0;  // known when the bytes are given away, too
    std::string sha256;
};

struct ProbeResult {
    size_t probe = 0;  // index into JobSpec::probes
    LightingState state;
    RenderSettings settings;  // of the render that is in the files
    std::array<CostStats, kFaceCount> faces;
    std::array<uint64_t, kFaceCount> pixels{};
    bool limited = false;       // by a ray limit, or out of time
    int looks = 1;              // renders, the last of them in the files
    CostStats earlier_renders;  // of the looks before
    Audit certificate;          // empty without audit
    CostStats decision_cost;    // of the audits that decided
    bool is_float = false;      // a value of a file did not fit into HALF
    bool inside_voxel = false;
    double far_m = 0.0;  // effective
    double wall_seconds = 0.0;
    std::vector<ProductFile> files;

    CostStats render_cost() const;
};

/// What the engine decides for a unit.
struct UnitParams {
    size_t probe = 0;
    /// The job's wall time is used up: the cheapest settings, no second look.
    bool out_of_time = false;
};

/// Throws Cancelled.
ProbeResult bake_probe(const Scene& scene, const JobSpec& job, const Pilot& pilot,
                       const UnitParams& unit, const CancelToken& cancel);

/// Audited pixels of a probe: as asked for, else as many as these rays pay for, at least 64 and
/// between a hundredth and a tenth of its texels; for irradiance, which needs many, up to all.
int audit_pixels(const QualitySpec& quality, int truth_grid, int face_size_px, double rays);

}  // namespace probebake
