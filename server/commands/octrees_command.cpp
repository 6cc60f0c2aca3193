// probebake study octrees --out DIR --data FOLDER: the octree traversals of Havran 1999.
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "commands/local_job.h"
#include "commands/terminal.h"
#include "engine/render_pool.h"
#include "study/octrees/octree_study.h"

namespace probebake {
namespace {

struct OctreesOptions {
    study::OctreeStudyParams study;
    int threads = available_threads();
    bool json = false;
};

int octrees(const OctreesOptions& options) {
    RenderPool pool(options.threads);
    ProgressBar bar(options.json);
    study::OctreeStudyOutcome outcome;
    pool.run([&] {
        outcome = study::run_octree_study(options.study, [&](const study::StudyProgress& progress) {
            bar.show(progress.what, progress.done, progress.total, std::nullopt);
        });
    });
    if (options.json) {
        const Json json = {{"computed", outcome.computed},
                           {"found", outcome.found},
                           {"left_out", outcome.left_out},
                           {"summary", outcome.summary},
                           {"results", outcome.results}};
        std::cout << dump_json(json, 2) << '\n';
        return 0;
    }
    std::cout << outcome.computed << " scenes measured, " << outcome.found
              << " were there already\n";
    for (const std::string& left : outcome.left_out) std::cout << "left out: " << left << '\n';
    std::cout << "report: " << (options.study.out / "report.md").string() << '\n';
    return 0;
}

}  // namespace

void add_octrees_command(CLI::App& study_app, CommandWork& work) {
    std::string scenes;
    for (const char* name : study::kOctreeScenes) {
        scenes += (scenes.empty() ? "" : ", ") + std::string(name);
    }
    auto* command = study_app.add_subcommand(
        "octrees", "Octree traversals of 1984, 1989 and 1993, as Havran compared them in 1999");
    const auto options = std::make_shared<OctreesOptions>();
    command->add_option("--out", options->study.out, "Folder for results and report")->required();
    command
        ->add_option("--data", options->study.data_folder,
                     "Folder with spd/*.nff and octrees/havran_1999.csv")
        ->envname("PROBEBAKE_DATA")
        ->check(CLI::ExistingDirectory)
        ->required();
    command->add_option("--scenes", options->study.scenes, "Only these: " + scenes)->delimiter(',');
    command->add_option("--depths", options->study.measure.depths, "Only these of 4,5,6,7")
        ->delimiter(',');
    command
        ->add_option("--size", options->study.measure.size_px,
                     "Pixels per side; 512 for figures comparable with those of 1999")
        ->capture_default_str();
    command->add_option("--threads", options->threads, "Threads")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command->add_flag("--json", options->json, "Print the results as JSON");
    command->callback([options, &work] { work = [options] { return octrees(*options); }; });
}

}  // namespace probebake
