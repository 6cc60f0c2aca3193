// What the studies of many scenes share on the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "commands/local_job.h"
#include "commands/terminal.h"
#include "engine/render_pool.h"
#include "io/json.h"
#include "study/study.h"

namespace probebake {

struct StudyRun {
    int threads = available_threads();
    bool json = false;
};

/// --out, --scenes, --size, --data, --cache of a study's parameters; --threads, --json of its run.
template <class Params>
void add_study_options(CLI::App& command, Params& params, StudyRun& run,
                       const std::vector<std::string>& scenes) {
    command.add_option("--out", params.out, "Folder for results and report")->required();
    command.add_option("--scenes", params.scenes, "Only these: " + CLI::detail::join(scenes, ", "))
        ->delimiter(',');
    command
        .add_option("--size", params.size,
                    "Side of the generated worlds, a power of two from 128 to 2048")
        ->capture_default_str();
    command.add_option("--data", params.data_folder, "Folder of real scenes")
        ->envname("PROBEBAKE_DATA");
    command.add_option("--cache", params.cache_folder,
                       "Folder that keeps built voxel trees between runs");
    command.add_option("--threads", run.threads, "Render threads")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command.add_flag("--json", run.json, "Print the results as JSON");
}

/// Runs a study (params, on_progress) -> outcome on a pool of its own and shows its progress.
template <class Params, class Study>
auto run_on_pool(const StudyRun& run, const Params& params, Study study) {
    RenderPool pool(run.threads);
    ProgressBar bar(run.json);
    decltype(study(params, std::function<void(const study::StudyProgress&)>())) outcome;
    pool.run([&] {
        outcome = study(params, [&](const study::StudyProgress& progress) {
            bar.show(progress.what, progress.done, progress.total, std::nullopt);
        });
    });
    return outcome;
}

/// Where the results lie, for people. `what` is computed: "scenes", "results".
template <class Outcome>
void print_study(const Outcome& outcome, const std::string& what,
                 const std::filesystem::path& out) {
    std::cout << outcome.computed << ' ' << what << " computed, " << outcome.found
              << " were there already\n";
    for (const std::string& left : outcome.left_out) std::cout << "left out: " << left << '\n';
    std::cout << "report: " << (out / "report.md").string() << '\n';
}

}  // namespace probebake
