// probebake study calibration --out DIR: whether promised errors are kept, and what that costs.
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "commands/local_job.h"
#include "commands/terminal.h"
#include "engine/render_pool.h"
#include "study/calibration/calibration.h"

namespace probebake {
namespace {

struct CalibrationOptions {
    study::CalibrationParams study;
    int threads = available_threads();
    bool json = false;
};

int calibration(const CalibrationOptions& options) {
    RenderPool pool(options.threads);
    ProgressBar bar(options.json);
    study::CalibrationOutcome outcome;
    pool.run([&] {
        outcome = study::run_calibration(options.study, [&](const study::StudyProgress& progress) {
            bar.show(progress.what, progress.done, progress.total, std::nullopt);
        });
    });
    if (options.json) {
        std::cout << dump_json({{"computed", outcome.computed},
                                {"found", outcome.found},
                                {"left_out", outcome.left_out},
                                {"summary", outcome.summary}},
                               2)
                  << '\n';
        return 0;
    }
    std::cout << outcome.computed << " jobs computed, " << outcome.found << " were there already\n";
    for (const std::string& left : outcome.left_out) std::cout << "left out: " << left << '\n';
    std::cout << "report: " << (options.study.out / "report.md").string() << '\n';
    return 0;
}

}  // namespace

void add_calibration_command(CLI::App& study_app, CommandWork& work) {
    std::string scenes;
    for (const std::string& name : study::calibration_scene_names()) {
        scenes += (scenes.empty() ? "" : ", ") + name;
    }
    auto* command = study_app.add_subcommand(
        "calibration", "Whether promised errors are kept on baked probes, and what that costs");
    const auto options = std::make_shared<CalibrationOptions>();
    command->add_option("--out", options->study.out, "Folder for results and report")->required();
    command->add_option("--scenes", options->study.scenes, "Only these: " + scenes)->delimiter(',');
    command->add_option("--faces", options->study.faces, "Only these face sizes: 16, 32, 64")
        ->delimiter(',')
        ->check(CLI::IsMember({16, 32, 64}));
    command
        ->add_option("--probes-per-job", options->study.probes_per_job,
                     "Jobs of so many probes instead of one per scene, face size and light")
        ->check(CLI::PositiveNumber);
    command
        ->add_option("--size", options->study.size,
                     "Side of the generated worlds, a power of two from 128 to 2048")
        ->capture_default_str();
    command->add_option("--share", options->study.share, "Of the probes of a full run")
        ->check(CLI::Range(0.01, 10.0))
        ->capture_default_str();
    command->add_option("--data", options->study.data_folder, "Folder of real scenes")
        ->envname("PROBEBAKE_DATA");
    command->add_option("--cache", options->study.cache_folder,
                        "Folder that keeps built voxel trees between runs");
    command->add_option("--threads", options->threads, "Render threads")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command->add_flag("--json", options->json, "Print the summary as JSON");
    command->callback([options, &work] { work = [options] { return calibration(*options); }; });
}

}  // namespace probebake
