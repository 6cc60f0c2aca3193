// What a job is told about its result: verdicts, errors with intervals, costs, curves.
//
// The report has no rows per probe: those are written one by one (write_probe_row), so that 65,536
// probes never make one document. docs/report.md documents every field.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/pilot.h"
#include "bake/probe_places.h"
#include "bake/probe_result.h"
#include "bake/verdict.h"

namespace probebake {

/// A finished bake, as far as the report is concerned. Results may have given their files' bytes
/// away.
struct BakeRecord {
    const Scene& scene;
    const JobSpec& job;
    const Plan& plan;
    const std::vector<Pilot>& pilots;         // one per state, in the order of JobSpec::states
    const std::vector<ProbeResult>& results;  // those that were finished
    std::span<const GridResult> grid_results;
    double wall_seconds = 0.0;  // pilot and render
    double seconds_to_first_probe = 0.0;
    uint64_t peak_memory_bytes = 0;  // of the process
    int threads = 1;
    std::vector<std::string> warnings;
    PlacesRecord places;
};

Json write_report(const BakeRecord& record);
/// The row of one result; `pooled` belongs to its state.
Json write_probe_row(const BakeRecord& record, const Pilot& pilot, const ProbeResult& result,
                     const MeasuredError& pooled);

/// The row of a grid's files.
Json write_grid_row(const GridResult& result);

/// Name, size and place of a scene, and what loading it took.
Json write_scene(const Scene& scene);

/// Version, compiler, kernels and machine: what the determinism of the bytes is promised for.
Json provenance(int threads);

/// What is wrong with a job that is to fail (JobSpec::on_budget_exhausted) where a budget kept
/// cubemaps from their targets.
std::optional<std::string> budget_failure(const JobSpec& job, const Json& report);

}  // namespace probebake
