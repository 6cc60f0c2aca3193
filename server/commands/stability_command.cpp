// probebake study stability --out DIR: stiff and extreme cases, each with its bound.
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "commands/local_job.h"
#include "engine/render_pool.h"
#include "volume_study/stability.h"

namespace probebake {
namespace {

struct StabilityOptions {
    std::filesystem::path out;
    bool full = false;
    int threads = available_threads();
};

/// 1 where a case fails.
int stability(const StabilityOptions& options) {
    RenderPool pool(options.threads);
    volume_study::StabilityReport report;
    pool.run([&] {
        report = volume_study::run_stability_study(
            options.out, options.full, [](const std::string& what) { std::cerr << what << '\n'; });
    });
    std::cout << report.table.markdown() << report.failed << " of " << report.table.rows.size()
              << " cases fail\n";
    return report.failed == 0 ? 0 : 1;
}

}  // namespace

void add_stability_command(CLI::App& study_app, CommandWork& work) {
    auto* command = study_app.add_subcommand(
        "stability", "Stiff and extreme cases of media and voxels: value, bound, pass");
    const auto options = std::make_shared<StabilityOptions>();
    command->add_option("--out", options->out, "Folder for the table")->required();
    command->add_flag("--full", options->full, "A room in cubes of 4096², too: minutes");
    command->add_option("--threads", options->threads, "Threads")->check(CLI::Range(1, 1024));
    command->callback([options, &work] { work = [options] { return stability(*options); }; });
}

}  // namespace probebake
