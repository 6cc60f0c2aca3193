#include "engine/bake_run.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>

#include "bake/probe_files.h"
#include "engine/remaining_time.h"

namespace probebake {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

class BakeRun {
  public:
    explicit BakeRun(const BakeParams& params) : params_(params), job_(params.job) {}

    Json run() {
        enter(BakePhase::kLoading);
        scene_ = params_.scene(params_.cancel);
        params_.cancel.throw_if_cancelled();
        plan_ = make_plan(*scene_, job_);
        begin_ = Clock::now();  // a budget of seconds does not pay for loading
        light();
        enter(BakePhase::kPilot);
        tune();
        enter(BakePhase::kRendering);
        render();
        if (job_.products.ddgi) make_atlases();
        enter(BakePhase::kFinished);
        return finish();
    }

  private:
    void enter(BakePhase phase) {
        const std::lock_guard lock(mutex_);
        progress_.phase = phase;
        progress_.units = job_.probes.size() * job_.states.size();
        report_progress();
    }

    void report_progress() {  // with mutex_ held
        const Clock::time_point now = Clock::now();
        progress_.seconds = seconds_between(start_, now);
        if (progress_.units_done > 0) {
            const RemainingTime left = unit_times_.left(
                seconds_between(render_begin_, now),
                static_cast<double>(progress_.units - progress_.units_done), pixels_left_);
            progress_.seconds_left = left.seconds;
            progress_.seconds_left_interval = left.interval;
        }
        if (params_.on_progress) params_.on_progress(progress_);
    }

    double seconds_left() const {
        return job_.budget.seconds.value_or(0.0) - seconds_between(begin_, Clock::now());
    }
    bool out_of_time() const { return job_.budget.seconds && seconds_left() <= 0.0; }

    void light() {
        const bool any = std::any_of(job_.states.begin(), job_.states.end(),
                                     [](const LightingState& state) { return state.lit(); });
        if (any) enter(BakePhase::kLighting);
        for (size_t s = 0; s < job_.states.size(); ++s) {
            params_.pool.run(
                [&] { states_.push_back(light_state(*scene_, job_, s, params_.cancel)); });
        }
    }

    void tune() {
        for (size_t s = 0; s < job_.states.size(); ++s) {
            std::optional<TimeBudget> time;
            if (job_.budget.seconds) {
                // What is left, in equal parts for this state and those after it.
                time = {params_.pool.threads(), std::max(0.0, seconds_left()) /
                                                    static_cast<double>(job_.states.size() - s)};
            }
            params_.pool.run([&] {
                pilots_.push_back(
                    run_pilot(*scene_, job_, plan_, states_[s], params_.cancel, time));
            });
        }
    }

    void render() {
        render_begin_ = Clock::now();
        pixels_left_ = static_cast<double>(pixel_count(job_));
        results_.resize(job_.probes.size() * job_.states.size());
        // The audits of the first probes tell how wrong the others' predictions will be.
        const size_t first = probes_to_learn_from(job_) * job_.states.size();
        render_units(0, first, true);
        learn_from(first);
        render_units(first, results_.size(), false);
    }

    void render_units(size_t begin, size_t end, bool teach) {
        params_.pool.for_each(end - begin, [&](size_t k) {
            const size_t i = begin + k;
            params_.cancel.throw_if_cancelled();
            // Probe by probe, so that a probe's states end together.
            const UnitParams unit{
                .probe = i / job_.states.size(), .out_of_time = out_of_time(), .teaches = teach};
            ProbeResult result =
                bake_probe(*scene_, job_, pilots_[i % job_.states.size()], unit, params_.cancel);
            publish(i, std::move(result));
        });
    }

    void learn_from(size_t units) {
        for (size_t s = 0; s < pilots_.size(); ++s) {
            std::vector<ProbeResult> results;
            for (size_t i = s; i < units; i += pilots_.size()) {
                results.push_back(results_[i]);
            }
            learn(pilots_[s], job_.quality, results);
        }
    }

    void make_atlases() {
        for (const ProbeGrid& grid : job_.grids) {
            for (size_t s = 0; s < states_.size(); ++s) {
                params_.cancel.throw_if_cancelled();
                GridResult result = atlas_of(grid, s);
                if (params_.grid_sink) params_.grid_sink(result);
                for (ProductFile& file : result.files) std::vector<std::byte>().swap(file.bytes);
                grid_results_.push_back(std::move(result));
            }
        }
    }

    GridResult atlas_of(const ProbeGrid& grid, size_t state) {
        ProbeAttributes about = state_attributes(*scene_, job_, states_[state]);
        about.near_m = job_.probes[grid.first_probe].near_m;
        about.far_m = job_.probes[grid.first_probe].far_m.value_or(about.far_m);
        std::vector<const DdgiTile*> tiles;
        for (size_t p = grid.first_probe; p < grid.first_probe + grid.size(); ++p) {
            const ProbeResult& result = results_[p * states_.size() + state];
            tiles.push_back(&*result.ddgi);
            about.valid = about.valid && !result.inside_voxel;
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
        if (progress_.units_done == 0) first_unit_seconds_ = seconds_between(start_, Clock::now());
        const auto pixels =
            static_cast<double>(owned_pixel_count(job_.probes[result.probe].face_size_px));
        unit_times_.add(result.wall_seconds, pixels);
        pixels_left_ -= pixels;
        results_[i] = std::move(result);
        ++progress_.units_done;
        report_progress();
    }

    Json finish() const {
        const BakeRecord record{.scene = *scene_,
                                .job = job_,
                                .plan = plan_,
                                .pilots = pilots_,
                                .results = results_,
                                .grid_results = grid_results_,
                                .wall_seconds = seconds_between(begin_, Clock::now()),
                                .seconds_to_first_probe = first_unit_seconds_,
                                .peak_memory_bytes = peak_memory_bytes(),
                                .threads = params_.pool.threads()};
        std::vector<MeasuredError> pooled;
        for (const Pilot& pilot : pilots_) pooled.push_back(pooled_error(record, pilot.state.spec));
        for (size_t i = 0; params_.row_sink && i < results_.size(); ++i) {
            const size_t state = i % pilots_.size();
            params_.row_sink(write_probe_row(record, pilots_[state], results_[i], pooled[state]));
        }
        for (size_t i = 0; params_.row_sink && i < grid_results_.size(); ++i) {
            params_.row_sink(write_grid_row(grid_results_[i]));
        }
        return write_report(record);
    }

    const BakeParams& params_;
    const JobSpec& job_;
    const Clock::time_point start_ = Clock::now();
    Clock::time_point begin_ = start_;
    Clock::time_point render_begin_ = start_;
    std::shared_ptr<const Scene> scene_;
    Plan plan_;
    std::vector<ReadyState> states_;
    std::vector<Pilot> pilots_;
    std::vector<GridResult> grid_results_;

    std::mutex mutex_;
    // Guarded by mutex_ while units run:
    std::vector<ProbeResult> results_;
    BakeProgress progress_;
    double first_unit_seconds_ = 0.0;
    UnitTimes unit_times_;
    double pixels_left_ = 0.0;
};

}  // namespace

std::string_view name_of(BakePhase phase) {
    constexpr std::array<std::string_view, 5> kNames = {"loading", "lighting", "pilot", "rendering",
                                                        "finished"};
    return kNames[static_cast<size_t>(phase)];
}

Json run_bake(const BakeParams& params) { return BakeRun(params).run(); }

uint64_t peak_memory_bytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace probebake
