// read_job on anything: a job within the limits that reads back from what was understood of it, or
// a SpecError with pointers.
#include <cstdlib>
#include <string_view>

#include "bake/job_spec.h"
#include "bake/lighting_state.h"
#include "io/spec_error.h"

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace probebake;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    JobLimits limits;
    limits.max_probes = 4096;  // a grid of 65,536 takes its time under a sanitizer
    try {
        const JobSpec job = read_job(parse_json(text, {.max_values = 10'000}), limits);
        require(!job.probes.empty() && job.probes.size() <= limits.max_probes);
        require(!job.states.empty() && job.states.size() <= limits.max_states);
        require(texel_count(job) <= limits.max_texels);
        for (const ProbeSpec& probe : job.probes) {
            require(probe.face_size_px >= limits.min_face_size_px);
            require(probe.face_size_px <= limits.max_face_size_px);
            for (int axis = 0; axis < 3; ++axis) {
                require(std::abs(probe.position_m[axis]) <= limits.max_position_m);
            }
        }
        const Json understood = write_job(job);
        require(write_job(read_job(understood, limits)) == understood);
    } catch (const SpecError& error) {
        require(!error.issues().empty());
        for (const SpecIssue& issue : error.issues()) {
            require(issue.pointer.empty() || issue.pointer[0] == '/');
        }
    }
    return 0;
}
