// probebake study thesis --out DIR: the experiments of Müller 2020 on our scenes, and a report.
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "commands/local_job.h"
#include "commands/terminal.h"
#include "engine/render_pool.h"
#include "study/study.h"

namespace probebake {
namespace {

struct ThesisOptions {
    study::StudyParams study;
    int threads = available_threads();
    bool json = false;
};

std::string list_of(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
    return list;
}

int thesis(const ThesisOptions& options) {
    RenderPool pool(options.threads);
    ProgressBar bar(options.json);
    study::StudyOutcome outcome;
    pool.run([&] {
        outcome = study::run_study(options.study, [&](const study::StudyProgress& progress) {
            bar.show(progress.what, progress.done, progress.total, std::nullopt);
        });
    });
    if (options.json) {
        std::cout << dump_json({{"computed", outcome.computed},
                                {"found", outcome.found},
                                {"left_out", outcome.left_out},
                                {"plotted", outcome.plotted},
                                {"results", outcome.results}},
                               2)
                  << '\n';
        return 0;
    }
    std::cout << outcome.computed << " results computed, " << outcome.found
              << " were there already\n";
    for (const std::string& left : outcome.left_out) std::cout << "left out: " << left << '\n';
    if (!outcome.plotted) std::cout << "no gnuplot: plots are left as scripts\n";
    std::cout << "report: " << (options.study.out / "report.md").string() << '\n';
    return 0;
}

}  // namespace

void add_thesis_command(CLI::App& study_app, CommandWork& work) {
    auto* command = study_app.add_subcommand(
        "thesis", "Experiments of Müller 2020 on our scenes: tables, plots and a report");
    const auto options = std::make_shared<ThesisOptions>();
    command->add_option("--out", options->study.out, "Folder for results and report")->required();
    command
        ->add_option("--scenes", options->study.scenes,
                     "Only these: " + list_of(study::scene_names()))
        ->delimiter(',');
    command
        ->add_option("--only", options->study.experiments,
                     "Only these experiments: " + list_of(study::experiment_names()))
        ->delimiter(',');
    command
        ->add_option("--size", options->study.size,
                     "Side of the generated worlds, a power of two; the thesis's is 2048")
        ->capture_default_str();
    command->add_option("--data", options->study.data_folder, "Folder of real scenes")
        ->envname("PROBEBAKE_DATA");
    command->add_option("--cache", options->study.cache_folder,
                        "Folder that keeps built voxel trees between runs");
    command->add_option("--threads", options->threads, "Render threads")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command->add_flag("--json", options->json, "Print the results as JSON");
    command->callback([options, &work] { work = [options] { return thesis(*options); }; });
}

}  // namespace probebake
