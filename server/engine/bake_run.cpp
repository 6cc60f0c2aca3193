#include "engine/bake_run.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <new>

#include "bake/bake_probe.h"
#include "bake/learn.h"
#include "bake/probe_files.h"
#include "bake/state_error.h"

namespace probebake {
namespace {

using Clock = std::chrono::steady_clock;

/// What a standard deviation of the logarithm of units' seconds per pixel is expected to be.
constexpr double kSpread = 0.5;
constexpr double kSpreadThroughMedia = 2.0;
/// What is left is told anew so often at most: it takes longer than the smallest units.
constexpr double kTellLeftSeconds = 0.1;

double seconds_between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

size_t index_of_state(const JobSpec& job, std::string_view name) {
    size_t state = 0;
    while (name_of(job.states[state]) != name) ++state;
    return state;
}

class BakeRun {
  public:
    explicit BakeRun(const BakeParams& params) : params_(params), job_(params.job) {
        for (const auto& [unit, why] : params.history.given_up) {
            if (is_wanted(unit)) failed_.emplace(unit, why);
        }
    }

    Json run() {
        enter(BakePhase::kLoading);
        scene_ = params_.scene(params_.cancel);
        params_.cancel.throw_if_cancelled();
        params_.pool.run([&] { places_ = place_probes(*scene_, job_, params_.cancel); });
        plan_ = make_plan(*scene_, job_);
        begin_ = Clock::now();  // a budget of seconds does not pay for loading
        light();
        enter(BakePhase::kPilot);
        tune();
        enter(BakePhase::kRendering);
        render();
        if (job_.products.ddgi) make_atlases();
        enter(BakePhase::kFinished);
        if (!failed_.empty()) throw_failed();
        if (params_.history.only) return nullptr;
        return finish();
    }

  private:
    void enter(BakePhase phase) {
        const std::lock_guard lock(mutex_);
        progress_.phase = phase;
        progress_.units = unit_count(job_);
        progress_.units_done = params_.history.finished.size() + baked_;
        report_progress();
    }

    void report_progress() {  // with mutex_ held
        const Clock::time_point now = Clock::now();
        progress_.seconds = seconds_between(start_, now);
        const bool is_told = progress_.seconds_left && progress_.units_done < progress_.units;
        if (!is_told || seconds_between(told_, now) > kTellLeftSeconds) {
            progress_.tell_what_is_left(now);
            told_ = now;
        }
        if (params_.on_progress) params_.on_progress(progress_);
    }

    double seconds_left() const {
        return job_.budget.seconds.value_or(0.0) - seconds_between(begin_, Clock::now());
    }
    bool out_of_time() const { return job_.budget.seconds && seconds_left() <= 0.0; }

    /// Of all threads together, an equal part of what is left. With mutex_ held.
    double seconds_of_a_unit() const {
        const auto units = static_cast<double>(progress_.units - progress_.units_done);
        return std::max(0.0, seconds_left()) * params_.pool.threads() / std::max(1.0, units);
    }

    void light() {
        const bool any = std::any_of(job_.states.begin(), job_.states.end(),
                                     [](const LightingState& state) { return state.lit(); });
        if (any) enter(BakePhase::kLighting);
        for (size_t s = 0; s < job_.states.size(); ++s) {
            params_.pool.run([&] {
                states_.push_back(light_state(*scene_, job_, s, params_.cancel, params_.skies));
            });
        }
    }

    void tune() {
        std::optional<TimeBudget> time;
        if (job_.budget.seconds) time = {params_.pool.threads(), std::max(0.0, seconds_left())};
        for (size_t s = 0; s < job_.states.size(); ++s) {
            params_.pool.run([&] {
                pilots_.push_back(
                    run_pilot(*scene_, job_, plan_, states_[s], params_.cancel, time));
            });
        }
    }

    bool is_wanted(size_t unit) const {
        const std::optional<std::set<size_t>>& only = params_.history.only;
        return !only || only->contains(unit);
    }

    size_t unit_of_grid(size_t grid, size_t state) const {
        return unit_count(job_) + grid * job_.states.size() + state;
    }

    /// Whether an atlas that alone is to be made needs this unit of a probe.
    bool is_wanted_by_grid(size_t unit) const {
        const ProbeGrid* const grid = grid_of(job_, unit / job_.states.size());
        if (!job_.products.ddgi || grid == nullptr) return false;
        const auto g = static_cast<size_t>(grid - job_.grids.data());
        return is_wanted(unit_of_grid(g, unit % job_.states.size()));
    }

    /// What is left to be baked.
    std::vector<size_t> units_to_bake() const {
        const BakeHistory& history = params_.history;
        std::vector<size_t> units;
        for (size_t i = 0; i < unit_count(job_); ++i) {
            if (history.finished.contains(i) || history.given_up.contains(i)) continue;
            // To be mended as it was, a unit needs those that it learnt from.
            if (!is_wanted(i) && !is_wanted_by_grid(i) && i >= teachers()) continue;
            units.push_back(i);
        }
        return units;
    }

    void render() {
        results_ = params_.history.finished;
        const std::vector<size_t> units = units_to_bake();
        start_times(units);
        // The audits of the first probes tell how wrong the others' predictions will be.
        const size_t first = teachers();
        render_units(units, [&](size_t i) { return i < first; });
        learn_from(first);
        render_units(units, [&](size_t i) { return i >= first; });
    }

    /// Units that others learn from, the first ones.
    size_t teachers() const { return probes_to_learn_from(job_) * job_.states.size(); }

    double owned_pixels(size_t unit) const {
        const ProbeSpec& probe = job_.probes[unit / job_.states.size()];
        return static_cast<double>(owned_pixel_count(probe.face_size_px));
    }

    void start_times(const std::vector<size_t>& units) {
        double pixels = 0.0;
        for (const size_t i : units) pixels += owned_pixels(i);
        const std::lock_guard lock(mutex_);
        progress_.times.start(Clock::now(), units.size(), pixels,
                              plan_.media ? kSpreadThroughMedia : kSpread);
    }

    template <class Which>
    void render_units(const std::vector<size_t>& units, const Which& which) {
        std::vector<size_t> together;
        std::vector<size_t> alone;  // so that no other is blamed
        for (const size_t i : units) {
            if (which(i)) (params_.history.suspects.contains(i) ? alone : together).push_back(i);
        }
        params_.pool.for_each(together.size(), [&](size_t k) { bake_unit(together[k]); });
        for (const size_t i : alone) params_.pool.run([&] { bake_unit(i); });
    }

    void bake_unit(size_t i) {
        params_.cancel.throw_if_cancelled();
        if (params_.begin) params_.begin(i);
        // Probe by probe, so that a probe's states end together.
        UnitParams unit{.probe = i / job_.states.size(),
                        .out_of_time = out_of_time(),
                        .teaches = i < teachers()};
        {
            const std::lock_guard lock(mutex_);
            if (job_.budget.seconds) unit.seconds = seconds_of_a_unit();
            progress_.times.begin_unit(i, owned_pixels(i), Clock::now());
        }
        ProbeResult result;
        try {
            result =
                bake_probe(*scene_, job_, pilots_[i % job_.states.size()], unit, params_.cancel);
        } catch (const Cancelled&) {
            throw;
        } catch (const std::bad_alloc&) {
            fail(i, "the service ran out of memory");
            return;
        } catch (const std::exception& error) {
            fail(i, error.what());
            return;
        }
        publish(i, std::move(result));
    }

    void fail(size_t i, const std::string& why) {
        const std::lock_guard lock(mutex_);
        failed_[i] = why;
        progress_.times.end_unit(i, Clock::now(), false);
    }

    void learn_from(size_t units) {
        for (size_t s = 0; s < pilots_.size(); ++s) {
            std::vector<ProbeResult> results;
            for (size_t i = s; i < units; i += pilots_.size()) {
                const auto at = results_.find(i);  // not there where it failed
                if (at != results_.end()) results.push_back(at->second);
            }
            learn(pilots_[s], job_.quality, results);
        }
    }

    void make_atlases() {
        for (size_t g = 0; g < job_.grids.size(); ++g) {
            for (size_t s = 0; s < states_.size(); ++s) {
                const size_t unit = unit_of_grid(g, s);
                if (!is_wanted(unit) || failed_.contains(unit)) continue;
                if (!is_complete(job_.grids[g], s)) continue;
                params_.cancel.throw_if_cancelled();
                if (params_.begin) params_.begin(unit);
                GridResult result = atlas_of(job_.grids[g], s);
                if (params_.grid_sink) params_.grid_sink(result);
                for (ProductFile& file : result.files) std::vector<std::byte>().swap(file.bytes);
                grid_results_.push_back(std::move(result));
            }
        }
    }

    bool is_complete(const ProbeGrid& grid, size_t state) const {
        for (size_t p = grid.first_probe; p < grid.first_probe + grid.size(); ++p) {
            if (!results_.contains(p * states_.size() + state)) return false;
        }
        return true;
    }

    GridResult atlas_of(const ProbeGrid& grid, size_t state) {
        ProbeAttributes about = state_attributes(*scene_, job_, states_[state]);
        about.near_m = job_.probes[grid.first_probe].near_m;
        about.far_m = job_.probes[grid.first_probe].far_m.value_or(about.far_m);
        std::vector<const DdgiTile*> tiles;
        for (size_t p = grid.first_probe; p < grid.first_probe + grid.size(); ++p) {
            const ProbeResult& result = results_.at(p * states_.size() + state);
            tiles.push_back(&*result.ddgi);
            about.valid = about.valid && job_.probes[p].place->valid;
        }
        GridResult result;
        params_.pool.run(
            [&] { result = encode_ddgi(grid, ddgi_atlas(grid.counts, tiles), std::move(about)); });
        return result;
    }

    void publish(size_t i, ProbeResult result) {
        const std::lock_guard lock(mutex_);
        if (params_.sink) params_.sink(job_.probes[result.probe], result);
        for (ProductFile& file : result.files) std::vector<std::byte>().swap(file.bytes);
        if (baked_ == 0) first_unit_seconds_ = seconds_between(start_, Clock::now());
        progress_.times.end_unit(i, Clock::now(), true);
        results_[i] = std::move(result);
        ++baked_;
        ++progress_.units_done;
        report_progress();
    }

    [[noreturn]] void throw_failed() const {
        std::vector<SpecIssue> issues;
        for (const auto& [i, why] : failed_) {
            const UnitLabel label = label_of(job_, i);
            issues.push_back(
                {(label.is_grid ? "/grids/" : "/probes/") + label.id + "/" + label.state, why});
        }
        throw UnitsFailed(std::move(issues));
    }

    Json finish() {
        std::vector<ProbeResult> results;
        results.reserve(results_.size());
        for (auto& [i, result] : results_) results.push_back(std::move(result));
        const BakeRecord record{.scene = *scene_,
                                .job = job_,
                                .plan = plan_,
                                .pilots = pilots_,
                                .results = results,
                                .grid_results = grid_results_,
                                .wall_seconds = seconds_between(begin_, Clock::now()),
                                .seconds_to_first_probe = first_unit_seconds_,
                                .peak_memory_bytes = peak_memory_bytes(),
                                .threads = params_.pool.threads(),
                                .places = places_};
        std::vector<MeasuredError> pooled;
        for (const Pilot& pilot : pilots_) pooled.push_back(pooled_error(record, pilot.state.spec));
        for (size_t i = 0; params_.row_sink && i < results.size(); ++i) {
            const size_t state = i % pilots_.size();
            params_.row_sink(write_probe_row(record, pilots_[state], results[i], pooled[state]));
        }
        for (size_t i = 0; params_.row_sink && i < grid_results_.size(); ++i) {
            params_.row_sink(write_grid_row(grid_results_[i]));
        }
        return write_report(record);
    }

    const BakeParams& params_;
    JobSpec job_;  // with its probes placed
    const Clock::time_point start_ = Clock::now();
    Clock::time_point begin_ = start_;
    std::shared_ptr<const Scene> scene_;
    PlacesRecord places_;
    Plan plan_;
    std::vector<ReadyState> states_;
    std::vector<Pilot> pilots_;
    std::vector<GridResult> grid_results_;

    std::mutex mutex_;
    // Guarded by mutex_ while units run:
    std::map<size_t, ProbeResult> results_;
    std::map<size_t, std::string> failed_;
    uint64_t baked_ = 0;  // in this attempt
    BakeProgress progress_;
    Clock::time_point told_ = start_;  // what is left
    double first_unit_seconds_ = 0.0;
};

}  // namespace

void BakeProgress::tell_what_is_left(UnitTimes::TimePoint now) {
    const std::optional<RemainingTime> left = times.left(now);
    if (!left) return;
    seconds_left = left->seconds;
    seconds_left_interval = left->interval;
}

std::string_view name_of(BakePhase phase) {
    constexpr std::array<std::string_view, 5> kNames = {"loading", "lighting", "pilot", "rendering",
                                                        "finished"};
    return kNames[static_cast<size_t>(phase)];
}

size_t unit_count(const JobSpec& job) { return job.probes.size() * job.states.size(); }

size_t unit_of(const JobSpec& job, const ProbeResult& result) {
    return result.probe * job.states.size() + index_of_state(job, name_of(result.state));
}

size_t unit_of(const JobSpec& job, const GridResult& result) {
    size_t grid = 0;
    while (job.grids[grid].id != result.grid) ++grid;
    return unit_count(job) + grid * job.states.size() + index_of_state(job, result.state);
}

UnitLabel label_of(const JobSpec& job, size_t unit) {
    const std::string state(name_of(job.states[unit % job.states.size()]));
    const size_t place = unit / job.states.size();
    if (place < job.probes.size()) return {false, job.probes[place].id, state};
    return {true, job.grids[place - job.probes.size()].id, state};
}

Json run_bake(const BakeParams& params) { return BakeRun(params).run(); }

uint64_t peak_memory_bytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace probebake
