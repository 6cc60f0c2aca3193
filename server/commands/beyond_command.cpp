// probebake study beyond --out DIR: the default renderer beside those of Müller 2020.
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "commands/study_options.h"
#include "study/beyond/beyond.h"

namespace probebake {
namespace {

struct BeyondOptions {
    study::BeyondParams study;
    StudyRun run;
};

int beyond(const BeyondOptions& options) {
    const study::BeyondOutcome outcome = run_on_pool(options.run, options.study, study::run_beyond);
    if (!options.run.json) {
        print_study(outcome, "scenes", options.study.out);
        return 0;
    }
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

}  // namespace

void add_beyond_command(CLI::App& study_app, CommandWork& work) {
    auto* command = study_app.add_subcommand(
        "beyond", "The default renderer beside those of Müller 2020, on scenes it was not made on");
    const auto options = std::make_shared<BeyondOptions>();
    add_study_options(*command, options->study, options->run, study::beyond_scene_names());
    command->add_option("--vox", options->study.vox, "A .vox file to judge on, too; repeatable")
        ->check(CLI::ExistingFile)
        ->allow_extra_args(false);
    command->add_option("--probes", options->study.probes, "Probes per scene")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    command->callback([options, &work] { work = [options] { return beyond(*options); }; });
}

}  // namespace probebake
