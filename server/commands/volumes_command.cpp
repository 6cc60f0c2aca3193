// probebake study volumes --out DIR: trackers and octrees of media, beside Kutz et al. 2017.
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "commands/local_job.h"
#include "engine/render_pool.h"
#include "volume_study/volume_study.h"

namespace probebake {
namespace {

struct VolumesOptions {
    volume_study::VolumeStudyParams study;
    int threads = available_threads();
};

int volumes(const VolumesOptions& options) {
    RenderPool pool(options.threads);
    std::vector<study::TextTable> tables;
    pool.run([&] {
        tables = volume_study::run_volume_study(
            options.study, [](const std::string& what) { std::cerr << what << '\n'; });
    });
    for (const study::TextTable& table : tables) std::cout << table.markdown();
    std::cout << "report: " << (options.study.out / "report.md").string() << '\n';
    return 0;
}

}  // namespace

void add_volumes_command(CLI::App& study_app, CommandWork& work) {
    auto* command = study_app.add_subcommand(
        "volumes", "Trackers and majorant octrees on clouds: counts, variances, efficiencies");
    const auto options = std::make_shared<VolumesOptions>();
    command->add_option("--out", options->study.out, "Folder for tables and report")->required();
    command->add_option("--cloud", options->study.cloud, "OpenVDB file with a grid 'density'");
    command
        ->add_option("--cumulus", options->study.cumulus_size,
                     "Lattice points per side of the generated cumulus; 0: none")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str();
    command->add_option("--paths", options->study.paths, "Paths per row of the depth tables")
        ->check(CLI::Range(1, 100'000'000))
        ->capture_default_str();
    command->add_option("--samples", options->study.samples, "Paths per row of the other tables")
        ->check(CLI::Range(2, 100'000'000))
        ->capture_default_str();
    command->add_option("--side", options->study.side, "Pixels per side of pictures")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command
        ->add_option("--reference", options->study.reference,
                     "Paths per pixel of each of two references of pictures")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
    command->add_option("--experiment", options->study.experiments, "Only this one; repeatable")
        ->check(CLI::IsMember(volume_study::experiment_names()));
    command->add_option("--threads", options->threads, "Threads")->check(CLI::Range(1, 1024));
    command->callback([options, &work] { work = [options] { return volumes(*options); }; });
}

}  // namespace probebake
