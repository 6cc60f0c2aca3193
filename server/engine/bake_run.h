// One bake from a checked request to its report, whoever asked for it: the service, or the command
// line without a service. Both give the same bytes.
//
//   scene -> plan -> light of every lit state -> pilot per state -> work units on the pool -> sink
//   -> rows and report
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "bake/report.h"
#include "engine/render_pool.h"

namespace probebake {

enum class BakePhase { kLoading, kLighting, kPilot, kRendering, kFinished };
std::string_view name_of(BakePhase phase);

struct BakeProgress {
    BakePhase phase = BakePhase::kLoading;
    uint64_t units_done = 0;
    uint64_t units = 0;
    double seconds = 0.0;                // since the bake began
    std::optional<double> seconds_left;  // expected, once units are done
    Interval seconds_left_interval;      // 95 %
};

struct BakeParams {
    const JobSpec& job;
    std::function<std::shared_ptr<const Scene>(const CancelToken&)> scene;
    RenderPool& pool;
    const CancelToken& cancel;
    /// Stores a result's files; called from pool threads, one call at a time, in the order in which
    /// units end. The bytes are released afterwards.
    std::function<void(const ProbeSpec&, const ProbeResult&)> sink;
    /// The same for what belongs to a whole grid, once all probes are done.
    std::function<void(const GridResult&)> grid_sink;
    std::function<void(const BakeProgress&)> on_progress;  // same calls, and at every phase
    /// Takes the row of every probe and state at the end, in the order of the request, then those
    /// of grids: verdicts need the whole job's evidence.
    std::function<void(const Json&)> row_sink;
};

/// The report. Throws SpecError where scene and job do not fit, Cancelled, and what scene and the
/// sinks throw.
Json run_bake(const BakeParams& params);

/// Largest resident set of this process so far.
uint64_t peak_memory_bytes();

}  // namespace probebake
