// One bake from a checked request to its report, whoever asked for it: the service, or the command
// line without a service. Both give the same bytes.
//
//   scene -> plan -> light of every lit state -> pilot per state -> work units on the pool -> sink
//   -> rows and report
//
// A bake that was interrupted goes on with what an earlier attempt finished: lighting and pilot are
// repeated (they depend on nothing but scene and job), finished units are not.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bake/report.h"
#include "engine/remaining_time.h"
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
    UnitTimes times;                     // tell both anew at any later time

    void tell_what_is_left(UnitTimes::TimePoint now);
};

/// Work units are counted probe by probe, states fastest; after them come the atlases of `ddgi`,
/// grid by grid.
size_t unit_count(const JobSpec& job);  // without the atlases
size_t unit_of(const JobSpec& job, const ProbeResult& result);
size_t unit_of(const JobSpec& job, const GridResult& result);

/// What a unit is called.
struct UnitLabel {
    bool is_grid = false;
    std::string id;  // of the probe or the grid
    std::string state;
};
UnitLabel label_of(const JobSpec& job, size_t unit);

/// What an earlier attempt left for this one. Atlases are always made again, of what is finished.
struct BakeHistory {
    std::map<size_t, ProbeResult> finished;  // not baked again
    std::set<size_t> suspects;               // baked last, one by one: they may end the process
    std::map<size_t, std::string> given_up;  // not baked, with the reason
    /// These alone, to mend their files; no report. What the job never had is given up, so that
    /// they learn from the same units again.
    std::optional<std::set<size_t>> only;
};

/// Some units could not be baked; all others are finished.
class UnitsFailed : public std::runtime_error {
  public:
    explicit UnitsFailed(std::vector<SpecIssue> issues)
        : std::runtime_error(std::to_string(issues.size()) + " work units failed"),
          issues_(std::move(issues)) {}
    /// "/probes/ID/STATE" or "/grids/ID/STATE" and what happened, in the order of the units.
    const std::vector<SpecIssue>& issues() const { return issues_; }

  private:
    std::vector<SpecIssue> issues_;
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
    /// Called before a unit is baked, from a pool thread but for atlases.
    std::function<void(size_t unit)> begin = {};
    BakeHistory history = {};
    /// Who decodes pictures of skies.
    SkySource skies = read_sky_file;
};

/// The report. Throws SpecError where scene and job do not fit, Cancelled, UnitsFailed, and what
/// scene and the sinks throw.
Json run_bake(const BakeParams& params);

/// Largest resident set of this process so far.
uint64_t peak_memory_bytes();

}  // namespace probebake
