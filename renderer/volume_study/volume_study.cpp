#include "volume_study/volume_study.h"

#include <algorithm>
#include <stdexcept>

#include "io/file.h"
#include "volume_study/depth_tables.h"
#include "volume_study/emitters.h"
#include "volume_study/figures.h"
#include "volume_study/probes.h"
#include "volume_study/tracker_tables.h"

namespace probebake::volume_study {

const std::vector<std::string>& experiment_names() {
    static const std::vector<std::string> names = {"depth",    "efficiency", "control",
                                                   "figure_4", "figure_6",   "figure_7",
                                                   "curves",   "probes",     "emitters"};
    return names;
}

std::vector<study::TextTable> run_volume_study(
    const VolumeStudyParams& params, const std::function<void(const std::string&)>& on_progress) {
    for (const std::string& name : params.experiments) {
        const auto& known = experiment_names();
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            throw std::invalid_argument("no experiment '" + name + "'");
        }
    }
    const auto wanted = [&](const char* name) {
        return params.experiments.empty() ||
               std::find(params.experiments.begin(), params.experiments.end(), name) !=
                   params.experiments.end();
    };
    std::error_code ignored;  // the first file that cannot be written says what is wrong
    std::filesystem::create_directories(params.out, ignored);
    on_progress("clouds");
    const std::vector<Cloud> clouds = load_clouds(params);
    if (clouds.empty()) throw std::invalid_argument("no cloud to study");
    std::vector<study::TextTable> tables;
    if (wanted("depth")) tables = depth_tables(clouds, params, on_progress);
    if (wanted("efficiency")) {
        for (auto& table : efficiency_tables(clouds.front(), params.samples, on_progress)) {
            tables.push_back(std::move(table));
        }
    }
    if (wanted("control"))
        tables.push_back(control_table(clouds.front(), params.samples, params.out));
    if (wanted("figure_4")) tables.push_back(first_flight_table(clouds.front(), params.samples));
    const FigureParams figure{
        .side = params.side, .reference = params.reference, .out = params.out};
    if (wanted("figure_6")) {
        on_progress("figure 6");
        tables.push_back(unbounded_table(clouds.front(), figure));
    }
    if (wanted("figure_7")) {
        on_progress("figure 7");
        tables.push_back(schemes_table(clouds.front(), figure));
    }
    if (wanted("curves")) tables.push_back(curve_table(clouds.front(), figure, on_progress));
    if (wanted("emitters")) tables.push_back(emitter_table(params.samples, on_progress));
    if (wanted("probes")) tables.push_back(probe_table(clouds.front(), params.out, on_progress));

    std::string report = "# Media: trackers and octrees\n\n";
    const auto write = [&](const std::string& name, const std::string& text) {
        write_file_atomically(params.out / name, text);
    };
    for (const study::TextTable& table : tables) {
        report += table.markdown();
        write(table.name + ".csv", table.csv());
    }
    write("report.md", report);
    return tables;
}

}  // namespace probebake::volume_study
