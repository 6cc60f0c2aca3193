// sh.json: a probe's radiance as spherical harmonics, with what is known of its error.
//
// docs/conventions.md documents the fields. The same input gives the same bytes.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bake/error_prior.h"
#include "bake/irradiance_noise.h"
#include "bake/sh_audit.h"
#include "image/exr.h"

namespace probebake {

/// What pixels that err independently lead to expect of the square of irradiance_rel, and what is
/// known of it.
struct ExpectedIrradiance {
    IrradianceNoise noise;
    PooledError square;
};

struct ShFile {
    const ShRgb& radiance;
    /// None where nothing was audited, or the audit was spared.
    const std::optional<ShAudit>& audit;
    double confidence = 0.95;       // the job's, of which the file speaks
    double look_confidence = 0.95;  // of the draws' own intervals: no lower
    /// In place of what the audit's draws say by themselves.
    std::optional<ExpectedIrradiance> expected;
    /// Whose they are, as the headers of the EXR files say it.
    const ProbeAttributes& probe;
};

std::vector<std::byte> encode_sh(const ShFile& file);

}  // namespace probebake
