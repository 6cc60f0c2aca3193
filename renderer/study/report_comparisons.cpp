#include "study/report_comparisons.h"

#include "study/experiment.h"

namespace probebake::study {

TextTable equal_steps_table(const Json& experiment, const std::string& name,
                            const std::string& title, const char* against) {
    TextTable table{.name = name, .title = title, .columns = {"scene", "over"}};
    for (const double budget : kBudgets) table.columns.push_back(text_of(budget) + "×");
    for (const auto& [scene, result] : experiment.items()) {
        for (const auto& [key, label] :
             {std::pair{"adaptive", "A"}, std::pair{"adaptive_black", "A'"}}) {
            std::vector<std::string> cells = {scene, label};
            for (const Json& row : result["rows"]) {
                cells.push_back(
                    decimals(rmse_of(row["error_aware"], against) / rmse_of(row[key], against), 3));
            }
            table.rows.push_back(std::move(cells));
        }
    }
    return table;
}

const Json& thesis_cost_row(const Json& result) {
    for (const Json& row : result["rows"]) {
        if (row["times_base"] == kThesisBudget) return row;
    }
    return result["rows"].front();
}

TextTable budget_thresholds_table(const Json& experiment) {
    TextTable table{.name = "budget_thresholds",
                    .title = "Thresholds that meet these costs, decay 0.2",
                    .columns = {"scene"}};
    for (const double budget : kBudgets) table.columns.push_back(text_of(budget) + "×");
    for (const auto& [scene, result] : experiment.items()) {
        std::vector<std::string> cells = {scene};
        for (const Json& row : result["rows"]) {
            cells.push_back(decimals(row["threshold"].get<double>(), 3));
        }
        table.rows.push_back(std::move(cells));
    }
    return table;
}

TextTable thesis_cost_table(const Json& experiment) {
    TextTable table{.name = "thesis_cost",
                    .title = "At twice the steps of one ray per pixel",
                    .columns = {"scene", "renderer", "rays per hit pixel", "not hit", "not refined",
                                "2×2", "4×4", "PSNR ref", "SSIM ref", "RMSE ref", "PSNR truth",
                                "SSIM truth", "RMSE truth"}};
    for (const auto& [scene, result] : experiment.items()) {
        const Json& at = thesis_cost_row(result);
        for (const char* renderer : {"error_aware", "adaptive", "adaptive_black"}) {
            const Json& row = at[renderer];
            std::vector<std::string> cells = {scene, renderer,
                                              decimals(row["rays_per_hit_pixel"].get<double>(), 3)};
            const std::vector<std::string> rest = class_and_error_cells(row);
            cells.insert(cells.end(), rest.begin(), rest.end());
            table.rows.push_back(std::move(cells));
        }
    }
    return table;
}

TextTable thesis_cost_ratios_table(const Json& experiment, bool with_thesis) {
    TextTable table{.name = "thesis_cost_ratios",
                    .title = titled("Error-aware over adaptive at twice the steps of one ray per "
                                    "pixel",
                                    with_thesis,
                                    "figures (tables 5.2-5.17: rays per pixel, RMSE), whose "
                                    "adaptive renderer takes other steps"),
                    .columns = {"scene", "error-aware rays per hit pixel", "RMSE / A, reference",
                                "RMSE / A', reference", "RMSE / A, truth", "RMSE / A', truth"}};
    for (const auto& [scene, result] : experiment.items()) {
        const Json& row = thesis_cost_row(result);
        const Json& ea = row["error_aware"];
        std::optional<double> rays;
        std::optional<double> rmse;
        if (const ThesisArea* area = thesis_area(scene)) {
            rays = static_cast<double>(area->error_aware.rays) /
                   (512.0 * 512.0 - static_cast<double>(area->error_aware.classes[0]));
            rmse = area->error_aware.rmse / area->adaptive.rmse;
        }
        const auto over = [&](const char* other, const char* against) {
            return decimals(rmse_of(ea, against) / rmse_of(row[other], against), 3);
        };
        table.rows.push_back(
            {scene,
             beside(decimals(ea["rays_per_hit_pixel"].get<double>(), 3), with_thesis, rays, 3),
             beside(over("adaptive", "reference"), with_thesis, rmse, 3),
             over("adaptive_black", "reference"), over("adaptive", "truth"),
             over("adaptive_black", "truth")});
    }
    return table;
}

TextTable times_table(const Json& experiment, bool with_thesis) {
    TextTable table{
        .name = "times_of_day",
        .title = titled("Error-aware over adaptive under four positions of the sun", with_thesis,
                        "figures (tables 5.18-5.26; its positions are others)"),
        .columns = {"scene", "time", "sun's elevation", "mean luminance",
                    "adaptive rays / those in error-aware", "steps / A as in albedo",
                    "RMSE / that A, reference", "RMSE / A at equal steps, reference",
                    "RMSE / A at equal steps, truth", "RMSE / A' at equal steps, truth"}};
    for (const auto& [scene, result] : experiment.items()) {
        const ThesisArea* area = thesis_area(scene);
        for (const Json& row : result["rows"]) {
            const auto t = row["time"].get<size_t>();
            const Json& ea = row["error_aware"];
            const Json& fixed = row["adaptive_of_albedo"];
            std::optional<double> rays;
            std::optional<double> steps;
            std::optional<double> rmse;
            if (area != nullptr) {
                const ThesisTimeOfDay& time = area->times[t];
                rays = ratio(time.adaptive_rays, time.error_aware_rays);
                steps = ratio(time.error_aware_steps, time.adaptive_steps);
                rmse = time.error_aware_rmse / time.adaptive_rmse;
            }
            const auto over = [&](const char* other, const char* against) {
                return decimals(rmse_of(ea, against) / rmse_of(row[other], against), 3);
            };
            table.rows.push_back(
                {scene, std::to_string(t), decimals(row["elevation_deg"].get<double>(), 0) + "°",
                 decimals(row["luminance"].get<double>(), 4),
                 beside(decimals(hit_rays_of(fixed) / hit_rays_of(ea), 3), with_thesis, rays, 3),
                 beside(decimals(steps_of(ea) / steps_of(fixed), 3), with_thesis, steps, 3),
                 beside(over("adaptive_of_albedo", "reference"), with_thesis, rmse, 3),
                 over("adaptive", "reference"), over("adaptive", "truth"),
                 over("adaptive_black", "truth")});
        }
    }
    return table;
}

std::vector<TextTable> beam_tables(const Json& experiment) {
    TextTable modes{.name = "beam",
                    .title =
                        "Light on the floor over that of leaf rays (3.4-3.6); the grating "
                        "stands at z = 287",
                    .columns = {"level of detail", "light kept", "lit until z", "steps per ray",
                                "errors looked up per ray"}};
    TextTable profile{.name = "beam_profile",
                      .title = "Light by distance, over that of leaf rays",
                      .columns = {"z"}};
    for (const auto& [scene, result] : experiment.items()) {
        for (const Json& mode : result["modes"]) {
            modes.rows.push_back({mode["mode"].get<std::string>(),
                                  decimals(mode["kept"].get<double>(), 4),
                                  std::to_string(mode["lit_until_z"].get<int>()),
                                  decimals(mode["steps_per_ray"].get<double>(), 2),
                                  decimals(mode["errors_per_ray"].get<double>(), 2)});
            profile.columns.push_back(mode["mode"].get<std::string>());
        }
        for (const Json& line : result["profile"]) {
            if (line["z"].get<int>() % 50 != 0) continue;
            std::vector<std::string> cells = {std::to_string(line["z"].get<int>())};
            for (const Json& mode : result["modes"]) {
                const auto leaf = line["leaf"].get<double>();
                const auto light = line[mode["mode"].get<std::string>()].get<double>();
                cells.push_back(leaf > 0.0 ? decimals(light / leaf, 3) : "–");
            }
            profile.rows.push_back(std::move(cells));
        }
    }
    return {modes, profile};
}

TextTable thin_table(const Json& experiment) {
    TextTable table{
        .name = "thin",
        .title =
            "Light of the torch and breadth of the line over the truth's; in brackets the "
            "share of shifted pictures that show any of it, and rays per pixel",
        .columns = {"scene", "voxels per pixel", "reference", "LOD", "error-aware",
                    "error-aware, decay 1"}};
    for (const auto& [scene, result] : experiment.items()) {
        for (const Json& row : result["rows"]) {
            std::vector<std::string> cells = {scene,
                                              text_of(row["footprint_voxels"].get<double>())};
            for (const char* renderer :
                 {"reference", "lod", "error_aware", "error_aware_decay_1"}) {
                const Json& r = row[renderer];
                cells.push_back(decimals(r["kept"].get<double>(), 3) + " (" +
                                decimals(100.0 * r["seen"].get<double>(), 0) + " %, " +
                                decimals(r["rays_per_pixel"].get<double>(), 1) + ")");
            }
            table.rows.push_back(std::move(cells));
        }
    }
    return table;
}

}  // namespace probebake::study
