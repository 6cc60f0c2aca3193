// probebake study thesis --out DIR: the experiments of Müller 2020 on our scenes, and a report.
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "commands/study_options.h"

namespace probebake {
namespace {

struct ThesisOptions {
    study::StudyParams study;
    StudyRun run;
};

int thesis(const ThesisOptions& options) {
    const study::StudyOutcome outcome = run_on_pool(options.run, options.study, study::run_study);
    if (options.run.json) {
        std::cout << dump_json({{"computed", outcome.computed},
                                {"found", outcome.found},
                                {"left_out", outcome.left_out},
                                {"plotted", outcome.plotted},
                                {"results", outcome.results}},
                               2)
                  << '\n';
        return 0;
    }
    if (!outcome.plotted) std::cout << "no gnuplot: plots are left as scripts\n";
    print_study(outcome, "results", options.study.out);
    return 0;
}

}  // namespace

void add_thesis_command(CLI::App& study_app, CommandWork& work) {
    auto* command = study_app.add_subcommand(
        "thesis", "Experiments of Müller 2020 on our scenes: tables, plots and a report");
    const auto options = std::make_shared<ThesisOptions>();
    add_study_options(*command, options->study, options->run, study::scene_names());
    command
        ->add_option(
            "--only", options->study.experiments,
            "Only these experiments: " + CLI::detail::join(study::experiment_names(), ", "))
        ->delimiter(',');
    command->callback([options, &work] { work = [options] { return thesis(*options); }; });
}

}  // namespace probebake
