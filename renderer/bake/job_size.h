// What a job takes, as far as that is known without its scene: enough to refuse it before anything
// is loaded.
#pragma once

#include <cstdint>

#include "bake/job_spec.h"

namespace probebake {

struct JobSize {
    uint64_t unit_texels = 0;   // of the largest cubemap
    uint64_t unit_bytes = 0;    // memory of the largest work unit while it is rendered and encoded
    uint64_t output_bytes = 0;  // at most: uncompressed products
};

/// Of a job within JobLimits nothing overflows: 2^32 texels of less than 2^8 bytes.
JobSize size_of_job(const JobSpec& job);

}  // namespace probebake
