// probebake bake JOB.json --out DIR, and probebake check JOB.json: no service needed.
#include <iostream>
#include <memory>

#include "bake/forecast.h"
#include "bake/report_page.h"
#include "commands/commands.h"
#include "commands/local_job.h"
#include "commands/report_text.h"
#include "commands/terminal.h"
#include "engine/bake_run.h"
#include "io/file.h"

namespace probebake {
namespace {

struct BakeOptions {
    std::filesystem::path job;
    std::filesystem::path out;
    SceneOptions scenes;
    bool json = false;
};

std::shared_ptr<const Scene> load(const SceneOptions& options, const std::string& name) {
    return std::make_shared<const Scene>(load_scene(find_scene(options, name), options.cache));
}

void write_files(const std::filesystem::path& folder, std::span<const ProductFile> files) {
    std::filesystem::create_directories(folder);
    for (const ProductFile& file : files) write_file_atomically(folder / file.name, file.bytes);
}

int bake(const BakeOptions& options) {
    const JobSpec job = read_job_file(options.job);
    std::filesystem::create_directories(options.out);
    RenderPool pool(options.scenes.threads);
    const CancelToken cancel;
    ProgressBar bar(options.json);
    std::vector<Json> rows;
    const Json report =
        run_bake({.job = job,
                  .scene =
                      [&](const CancelToken&) {
                          std::shared_ptr<const Scene> scene;
                          pool.run([&] { scene = load(options.scenes, job.scene); });
                          return scene;
                      },
                  .pool = pool,
                  .cancel = cancel,
                  .sink =
                      [&](const ProbeSpec& probe, const ProbeResult& result) {
                          write_files(options.out / probe.id / name_of(result.state), result.files);
                      },
                  .grid_sink =
                      [&](const GridResult& result) {
                          write_files(options.out / result.grid / result.state, result.files);
                      },
                  .on_progress =
                      [&](const BakeProgress& progress) {
                          bar.show(std::string(name_of(progress.phase)), progress.units_done,
                                   progress.phase == BakePhase::kRendering ? progress.units : 0,
                                   progress.seconds_left);
                      },
                  .row_sink = [&](const Json& row) { rows.push_back(row); }});
    std::string lines;
    for (const Json& row : rows) lines += dump_json(row) + "\n";
    write_file_atomically(options.out / "report.json", dump_json(report, 2) + "\n");
    write_file_atomically(options.out / "report.html", report_page(report));
    write_file_atomically(options.out / "probes.jsonl", lines);
    if (options.json) {
        std::cout << dump_json(report, 2) << '\n';
    } else {
        std::cout << report_text(report, rows) << "files in " << options.out.string() << '\n';
    }
    if (const auto failure = budget_failure(job, report)) {
        std::cerr << "probebake: " << *failure << '\n';
        return 1;
    }
    return 0;
}

int check(const BakeOptions& options) {
    JobSpec job = read_job_file(options.job);
    RenderPool pool(options.scenes.threads);
    Json plan;
    Json places;
    Json forecast;
    pool.run([&] {
        const std::shared_ptr<const Scene> scene = load(options.scenes, job.scene);
        places = write_places(job, place_probes(*scene, job, {}));
        const Plan made = make_plan(*scene, job);
        plan = write_plan(made);
        forecast = write_forecast(make_forecast(*scene, job, made, pool.threads(), {}));
    });
    const Json answer = {{"valid", true},
                         {"effective_request", write_job(job)},
                         {"plan", std::move(plan)},
                         {"validity", std::move(places)},
                         {"estimate", std::move(forecast)}};
    if (options.json) {
        std::cout << dump_json(answer, 2) << '\n';
        return 0;
    }
    const Json& made = answer["plan"];
    std::cout << options.job.string() << " is valid: " << grouped(made["work_units"])
              << " cubemaps, " << grouped(made["texels"]) << " texels, at most "
              << bytes_text(made["output_bytes_at_most"]) << " of files\nscene "
              << bytes_text(made["memory"]["scene_bytes"]) << ", "
              << bytes_text(made["memory"]["bytes_per_work_unit"]) << " per cubemap at work\n";
    const Json& estimate = answer["estimate"];
    std::cout << "expected: " << fixed(estimate["seconds_range"][0], 1) << " to "
              << fixed(estimate["seconds_range"][1], 1) << " s, "
              << bytes_text(estimate["memory_bytes"]) << " of memory, "
              << bytes_text(estimate["output_bytes"]) << " of files\n";
    if (made.contains("media")) {
        for (const Json& medium : made["media"]["media"]) {
            std::cout << "medium " << medium.get<std::string>() << '\n';
        }
        std::cout << "tracker " << made["media"]["tracker"].get<std::string>() << " ("
                  << made["media"]["reason"].get<std::string>() << ")\n";
    }
    for (const Json& left : made["left_out"]) {
        std::cout << "left out: " << left["what"].get<std::string>() << " ("
                  << left["why"].get<std::string>() << ")\n";
    }
    for (const Json& warning : made["warnings"]) {
        std::cout << "warning: " << warning.get<std::string>() << '\n';
    }
    return 0;
}

}  // namespace

void add_report_command(CLI::App& app, CommandWork& work) {
    auto* command = app.add_subcommand("report", "A report as a page with plots, HTML");
    const auto report = std::make_shared<std::filesystem::path>();
    const auto out = std::make_shared<std::filesystem::path>();
    command->add_option("report", *report, "A report.json")->required();
    command->add_option("--out", *out, "HTML file to write")->required();
    command->callback([report, out, &work] {
        work = [report, out] {
            const std::vector<std::byte> bytes = read_file(*report);
            const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
            write_file_atomically(*out, report_page(parse_json(text, {.max_values = 10'000'000})));
            std::cout << out->string() << '\n';
            return 0;
        };
    });
}

void add_bake_command(CLI::App& app, CommandWork& work) {
    auto* command = app.add_subcommand("bake", "Bake a job here, without a service");
    const auto options = std::make_shared<BakeOptions>();
    command->add_option("job", options->job, "Job file (docs/request.md)")->required();
    command->add_option("--out", options->out, "Folder for cubemaps and report")->required();
    command->add_flag("--json", options->json, "Print the report as JSON");
    options->scenes.add_to(*command);
    command->callback([options, &work] { work = [options] { return bake(*options); }; });
}

void add_check_command(CLI::App& app, CommandWork& work) {
    auto* command = app.add_subcommand("check", "Check a job and show its plan, without baking");
    const auto options = std::make_shared<BakeOptions>();
    command->add_option("job", options->job, "Job file (docs/request.md)")->required();
    command->add_flag("--json", options->json, "Print the answer as JSON");
    options->scenes.add_to(*command);
    command->callback([options, &work] { work = [options] { return check(*options); }; });
}

}  // namespace probebake
