// probebake study beyond --out DIR: the default renderer beside those of Müller 2020.
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "commands/local_job.h"
#include "commands/terminal.h"
#include "engine/render_pool.h"
#include "study/beyond/beyond.h"

namespace probebake {
namespace {

struct BeyondOptions {
    study::BeyondParams study;
    int threads = available_threads();
    bool json = false;
};

int beyond(const BeyondOptions& options) {
    RenderPool pool(options.threads);
    ProgressBar bar(options.json);
    study::BeyondOutcome outcome;
    pool.run([&] {
        outcome = study::run_beyond(options.study, [&](const study::StudyProgress& progress) {
            bar.show(progress.what, progress.done, progress.total, std::nullopt);
        });
    });
    if (options.json) {
        Json json = {{"computed", outcome.computed},
                     {"found", outcome.found},
                     {"left_out", outcome.left_out},
                     {"summary", outcome.summary},
                     {"results", outcome.results}};
        if (outcome.fitted) {
            for (const auto& stage : *outcome.fitted) json["fitted"].push_back(stage);
        }
        std::cout << dump_json(json, 2) << '\n';
        return 0;
    }
    std::cout << outcome.computed << " scenes computed, " << outcome.found
              << " were there already\n";
    for (const std::string& left : outcome.left_out) std::cout << "left out: " << left << '\n';
    std::cout << "report: " << (options.study.out / "report.md").string() << '\n';
    return 0;
}

}  // namespace

void add_beyond_command(CLI::App& study_app, CommandWork& work) {
    std::string scenes;
    for (const std::string& name : study::beyond_scene_names()) {
        scenes += (scenes.empty() ? "" : ", ") + name;
    }
    auto* command = study_app.add_subcommand(
        "beyond", "The default renderer beside those of Müller 2020, on scenes it was not made on");
    const auto options = std::make_shared<BeyondOptions>();
    command->add_option("--out", options->study.out, "Folder for results and report")->required();
    command->add_option("--scenes", options->study.scenes, "Only these: " + scenes)->delimiter(',');
    command->add_option("--vox", options->study.vox, "A .vox file to judge on, too; repeatable")
        ->check(CLI::ExistingFile)
        ->allow_extra_args(false);
    command
        ->add_option("--size", options->study.size,
                     "Side of the generated worlds, a power of two from 128 to 2048")
        ->capture_default_str();
    command->add_option("--probes", options->study.probes, "Probes per scene")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    command->add_option("--data", options->study.data_folder, "Folder of real scenes")
        ->envname("PROBEBAKE_DATA");
    command->add_option("--cache", options->study.cache_folder,
                        "Folder that keeps built voxel trees between runs");
    command->add_option("--threads", options->threads, "Render threads")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command->add_flag("--json", options->json, "Print the results as JSON");
    command->callback([options, &work] { work = [options] { return beyond(*options); }; });
}

}  // namespace probebake
