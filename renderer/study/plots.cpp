#include "study/plots.h"

#include <spawn.h>
#include <sys/wait.h>

#include "io/file.h"
#include "study/experiment.h"
#include "study/report_comparisons.h"

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX has no header for it

namespace probebake::study {
namespace {

/// One line per scene: y over x.
struct Plot {
    std::string name;
    std::string title;
    std::string x_label;
    std::string y_label;
    bool log_x = false;
    bool log_y = false;
    std::vector<std::string> lines;
    std::vector<double> x;
    std::vector<std::vector<double>> y;  // y[line][x]
};

std::string data_of(const Plot& plot) {
    std::string text = "# x";
    for (const std::string& line : plot.lines) text += " " + line;
    text += "\n";
    for (size_t i = 0; i < plot.x.size(); ++i) {
        text += decimals(plot.x[i], 4);
        for (const auto& line : plot.y) text += " " + decimals(line[i], 6);
        text += "\n";
    }
    return text;
}

std::string script_of(const Plot& plot) {
    std::string text =
        "set terminal svg size 720,480 dynamic background rgb 'white'\n"
        "set output '" +
        plot.name + ".svg'\nset title \"" + plot.title + "\" noenhanced\nset xlabel '" +
        plot.x_label + "'\nset ylabel '" + plot.y_label +
        "'\nset key outside right noenhanced\nset grid\n";
    if (plot.log_x) text += "set logscale x 2\n";
    if (plot.log_y) text += "set logscale y\n";
    text += "plot ";
    for (size_t i = 0; i < plot.lines.size(); ++i) {
        text += (i > 0 ? ", \\\n     '" : "'") + plot.name +
                ".dat' using 1:" + std::to_string(i + 2) + " with linespoints title '" +
                plot.lines[i] + "'";
    }
    return text + "\n";
}

Plot equal_steps_plot(const Json& experiment, const std::string& name, const std::string& what) {
    Plot plot{.name = name,
              .title = "Error-aware over the better adaptive baseline, " + what,
              .x_label = "steps, in one ray per pixel",
              .y_label = "ratio of RMSE against the truth",
              .log_x = true,
              .x = {kBudgets.begin(), kBudgets.end()}};
    for (const auto& [scene, result] : experiment.items()) {
        plot.lines.push_back(scene);
        plot.y.emplace_back();
        for (const Json& row : result["rows"]) {
            plot.y.back().push_back(rmse_of(row["error_aware"], "truth") /
                                    std::min(rmse_of(row["adaptive"], "truth"),
                                             rmse_of(row["adaptive_black"], "truth")));
        }
    }
    return plot;
}

Plot thresholds_plot(const Json& experiment, const std::string& name, const std::string& label,
                     double (*figure)(const Json& row)) {
    Plot plot{.name = name,
              .title = label + " over the threshold, relative to 0.15",
              .x_label = "threshold",
              .y_label = label,
              .log_y = true,
              .x = {kThresholds.begin(), kThresholds.end()}};
    for (const auto& [scene, result] : experiment.items()) {
        plot.lines.push_back(scene);
        plot.y.emplace_back();
        for (const Json& row : result["rows"]) {
            plot.y.back().push_back(figure(row) / figure(result["rows"][1]));
        }
    }
    return plot;
}

Plot decays_plot(const Json& experiment) {
    Plot plot{.name = "decays",
              .title = "RMSE against the truth at equal steps over the decay, relative to 0.2",
              .x_label = "decay",
              .y_label = "ratio of RMSE",
              .x = {kDecays.begin(), kDecays.end()}};
    for (const auto& [scene, result] : experiment.items()) {
        plot.lines.push_back(scene);
        plot.y.emplace_back();
        for (const Json& row : result["decays"]) {
            plot.y.back().push_back(rmse_of(row, "truth") / rmse_of(result["decays"][3], "truth"));
        }
    }
    return plot;
}

}  // namespace

bool run_gnuplot(const std::filesystem::path& folder, const std::string& script) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", 1, 0);
    std::string program = "gnuplot";
    std::string argument = script;
    char* const arguments[] = {program.data(), argument.data(), nullptr};
    pid_t child = 0;
    const int failed = posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) return false;
    int status = 0;
    return ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool write_plots(const std::filesystem::path& folder, const Json& results,
                 const std::string& note) {
    std::vector<Plot> plots;
    if (results.contains("equal_steps")) {
        plots.push_back(equal_steps_plot(results["equal_steps"], "equal_steps", "study view"));
    }
    if (results.contains("probes")) {
        plots.push_back(equal_steps_plot(results["probes"], "probes_equal_steps", "light probes"));
    }
    if (results.contains("thresholds")) {
        const Json& thresholds = results["thresholds"];
        plots.push_back(thresholds_plot(thresholds, "threshold_rays", "rays that hit",
                                        [](const Json& row) { return hit_rays_of(row); }));
        plots.push_back(thresholds_plot(thresholds, "threshold_rmse", "RMSE against the reference",
                                        [](const Json& row) { return rmse_of(row, "reference"); }));
    }
    if (results.contains("threshold_decay")) {
        plots.push_back(decays_plot(results["threshold_decay"]));
    }
    std::filesystem::create_directories(folder);
    bool plotted = true;
    for (Plot& plot : plots) {
        plot.title += note;
        write_file_atomically(folder / (plot.name + ".dat"), data_of(plot));
        write_file_atomically(folder / (plot.name + ".gp"), script_of(plot));
        plotted = run_gnuplot(folder, plot.name + ".gp") && plotted;
    }
    return plotted;
}

}  // namespace probebake::study
