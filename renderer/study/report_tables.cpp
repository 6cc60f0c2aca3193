#include "study/report_tables.h"

#include "error/node_error.h"
#include "study/experiment.h"
#include "study/report_comparisons.h"
#include "study/report_light.h"

namespace probebake::study {
namespace {

TextTable scenes_table(const Json& rendering, bool with_thesis) {
    TextTable table{.name = "scenes",
                    .title = titled("Scenes (table 4.1)", with_thesis, "area of that name"),
                    .columns = {"scene", "voxels", "octree nodes per voxel", "pixels that hit",
                                "steps per LOD ray"}};
    for (const auto& [scene, result] : rendering.items()) {
        const Json& lod = renderer_row(result["renderers"], "lod");
        const ThesisArea* area = thesis_area(scene);
        const double pixels = lod["pixels"].get<double>();
        std::optional<double> nodes;
        std::optional<double> hit;
        if (area != nullptr) {
            nodes = ratio(area->octree_nodes, area->voxels);
            hit = 1.0 - static_cast<double>(area->error_aware.classes[0]) / (512.0 * 512.0);
        }
        table.rows.push_back({scene, grouped_digits(result["voxels"].get<uint64_t>()),
                              beside(decimals(ratio(result["octree_nodes"].get<uint64_t>(),
                                                    result["voxels"].get<uint64_t>()),
                                              3),
                                     with_thesis, nodes, 3),
                              beside(decimals(1.0 - lod["classes"][0].get<double>() / pixels, 3),
                                     with_thesis, hit, 3),
                              decimals(steps_of(lod) / pixels, 2)});
    }
    return table;
}

TextTable renderers_table(const Json& rendering, const std::string& name,
                          const std::string& title) {
    TextTable table{.name = name,
                    .title = title,
                    .columns = {"scene", "renderer", "rays per hit pixel", "rays per pixel, all",
                                "steps / LOD's", "not hit", "not refined", "2×2", "4×4", "PSNR ref",
                                "SSIM ref", "RMSE ref", "PSNR truth", "SSIM truth", "RMSE truth"}};
    for (const auto& [scene, result] : rendering.items()) {
        const double base = steps_of(renderer_row(result["renderers"], "lod"));
        for (const Json& row : result["renderers"]) {
            const double pixels = row["pixels"].get<double>();
            std::vector<std::string> cells = {scene, row["renderer"].get<std::string>(),
                                              decimals(row["rays_per_hit_pixel"].get<double>(), 3),
                                              decimals(row["rays"].get<double>() / pixels, 3),
                                              decimals(steps_of(row) / base, 3)};
            for (const Json& count : row["classes"]) {
                cells.push_back(decimals(100.0 * count.get<double>() / pixels, 1) + " %");
            }
            for (const char* against : {"reference", "truth"}) {
                const Json& error = row[against];
                cells.push_back(decimals(number_or_none(error["psnr_db"]), 2));
                cells.push_back(decimals(number_or_none(error["ssim"]), 4));
                cells.push_back(decimals(error["rmse"].get<double>(), 5));
            }
            table.rows.push_back(std::move(cells));
        }
    }
    return table;
}

TextTable ratios_table(const Json& rendering, bool with_thesis) {
    TextTable table{
        .name = "rendering_ratios",
        .title = titled("Error-aware over adaptive", with_thesis,
                        "figures (tables 5.2-5.17), against the reference and with unequal steps"),
        .columns = {"scene", "RMSE / A, reference", "RMSE / A', reference", "RMSE / A, truth",
                    "RMSE / A', truth", "RMSE / A with the desert's normaliser, reference",
                    "steps / that A", "rays / that A"}};
    for (const auto& [scene, result] : rendering.items()) {
        const Json& renderers = result["renderers"];
        const Json& ea = renderer_row(renderers, "error_aware");
        const ThesisArea* area = thesis_area(scene);
        const auto of = [&](const char* other, const char* against) {
            return decimals(rmse_of(ea, against) / rmse_of(renderer_row(renderers, other), against),
                            3);
        };
        std::vector<std::string> cells = {scene, of("adaptive", "reference"),
                                          of("adaptive_black", "reference"),
                                          of("adaptive", "truth"), of("adaptive_black", "truth")};
        bool has_desert = false;
        for (const Json& row : renderers) {
            if (row["renderer"] != "adaptive_desert") continue;
            has_desert = true;
            std::optional<double> rmse;
            std::optional<double> steps;
            std::optional<double> rays;
            if (area != nullptr) {
                rmse = area->error_aware.rmse / area->adaptive.rmse;
                steps = ratio(area->error_aware.steps, area->adaptive.steps);
                rays = ratio(area->error_aware.rays, area->adaptive.rays);
            }
            cells.push_back(beside(of("adaptive_desert", "reference"), with_thesis, rmse, 3));
            cells.push_back(
                beside(decimals(steps_of(ea) / steps_of(row), 3), with_thesis, steps, 3));
            cells.push_back(
                beside(decimals(hit_rays_of(ea) / hit_rays_of(row), 3), with_thesis, rays, 3));
        }
        if (!has_desert) cells.insert(cells.end(), 3, "–");
        table.rows.push_back(std::move(cells));
    }
    return table;
}

/// Cells relative to the one at decay 0.2 and threshold 0.15.
std::vector<TextTable> decay_tables(const Json& experiment, bool with_thesis) {
    TextTable cells{.name = "threshold_decay",
                    .title = titled("Rays that hit, relative to decay 0.2 and threshold 0.15",
                                    with_thesis, "desert (table 5.1)"),
                    .columns = {"scene", "decay"}};
    for (const double threshold : kThresholds) cells.columns.push_back(text_of(threshold));
    TextTable best{.name = "decays",
                   .title =
                       "RMSE against the truth at the steps of (0.2, 0.154), relative to decay "
                       "0.2; each decay has its own threshold for these steps",
                   .columns = {"scene"}};
    for (const double decay : kDecays) best.columns.push_back(text_of(decay));
    for (const auto& [scene, result] : experiment.items()) {
        double unit = 0.0;
        for (const Json& cell : result["cells"]) {
            if (cell["decay"] == kThesisDecay && cell["threshold"] == 0.15) {
                unit = hit_rays_of(cell);
            }
        }
        for (size_t d = 0; d < kDecays.size(); ++d) {
            std::vector<std::string> row = {scene, text_of(kDecays[d])};
            for (size_t t = 0; t < kThresholds.size(); ++t) {
                std::optional<double> thesis;
                if (scene == "desert" && d < kThesisDecays.size()) {
                    thesis = ratio(thesis_decay_rays()[d][t], thesis_decay_rays()[3][1]);
                }
                const Json& cell = result["cells"][d * kThresholds.size() + t];
                row.push_back(
                    beside(decimals(hit_rays_of(cell) / unit, 2), with_thesis, thesis, 2));
            }
            cells.rows.push_back(std::move(row));
        }
        double at_thesis = 0.0;
        for (const Json& row : result["decays"]) {
            if (row["decay"] == kThesisDecay) at_thesis = rmse_of(row, "truth");
        }
        std::vector<std::string> row = {scene};
        for (const Json& decay : result["decays"]) {
            row.push_back(decimals(rmse_of(decay, "truth") / at_thesis, 3));
        }
        best.rows.push_back(std::move(row));
    }
    return {cells, best};
}

TextTable thresholds_table(const Json& experiment, bool with_thesis) {
    TextTable table{.name = "thresholds",
                    .title = titled("Error-aware, decay 0.2, relative to threshold 0.15",
                                    with_thesis, "desert (tables 5.27, 5.28)"),
                    .columns = {"scene", "threshold", "rays that hit", "steps", "RMSE reference",
                                "RMSE truth", "SSIM reference"}};
    for (const auto& [scene, result] : experiment.items()) {
        const Json& unit = result["rows"][1];
        for (size_t t = 0; t < kThresholds.size(); ++t) {
            const Json& row = result["rows"][t];
            const ThesisThreshold& mine = thesis_thresholds()[t];
            const ThesisThreshold& one = thesis_thresholds()[1];
            const bool compare = with_thesis && scene == "desert";
            table.rows.push_back(
                {scene, text_of(kThresholds[t]),
                 beside(decimals(hit_rays_of(row) / hit_rays_of(unit), 2), compare,
                        ratio(mine.rays, one.rays), 2),
                 beside(decimals(steps_of(row) / steps_of(unit), 2), compare,
                        ratio(mine.steps, one.steps), 2),
                 beside(decimals(rmse_of(row, "reference") / rmse_of(unit, "reference"), 2),
                        compare, mine.rmse / one.rmse, 2),
                 decimals(rmse_of(row, "truth") / rmse_of(unit, "truth"), 2),
                 beside(decimals(number_or_none(row["reference"]["ssim"]), 4), compare, mine.ssim,
                        3)});
        }
    }
    return table;
}

TextTable resolutions_table(const Json& experiment, bool with_thesis) {
    TextTable table{
        .name = "resolutions",
        .title = titled("Rays that hit of a view over those of the next smaller one, and "
                        "RMSE of error-aware over adaptive",
                        with_thesis, "desert (tables 5.29, 5.30), whose levels are fixed"),
        .columns = {"scene", "levels", "pixels", "error-aware rays / smaller view's",
                    "adaptive rays / smaller view's", "RMSE reference", "RMSE truth"}};
    for (const auto& [scene, result] : experiment.items()) {
        for (const char* levels : {"fixed", "pixel"}) {
            std::vector<const Json*> rows;
            for (const Json& row : result["rows"]) {
                if (row["level_of_detail"] == levels) rows.push_back(&row);
            }
            for (size_t i = 0; i < rows.size(); ++i) {
                const Json& row = *rows[i];
                const bool compare =
                    with_thesis && scene == "desert" && std::string_view(levels) == "fixed";
                const auto& thesis = thesis_resolutions();
                std::string ea = "–";
                std::string adaptive = "–";
                if (i + 1 < rows.size()) {
                    const Json& smaller = *rows[i + 1];
                    ea = beside(decimals(hit_rays_of(row["error_aware"]) /
                                             hit_rays_of(smaller["error_aware"]),
                                         2),
                                compare,
                                ratio(thesis[i].error_aware_rays, thesis[i + 1].error_aware_rays),
                                2);
                    adaptive = beside(
                        decimals(hit_rays_of(row["adaptive"]) / hit_rays_of(smaller["adaptive"]),
                                 2),
                        compare, ratio(thesis[i].adaptive_rays, thesis[i + 1].adaptive_rays), 2);
                }
                const auto over = [&](const char* against) {
                    return decimals(
                        rmse_of(row["error_aware"], against) / rmse_of(row["adaptive"], against),
                        3);
                };
                table.rows.push_back({scene, levels,
                                      std::to_string(row["view_px"].get<int>()) + "²", ea, adaptive,
                                      beside(over("reference"), compare,
                                             thesis[std::min<size_t>(i, 3)].error_aware_rmse /
                                                 thesis[std::min<size_t>(i, 3)].adaptive_rmse,
                                             3),
                                      over("truth")});
            }
        }
    }
    return table;
}

}  // namespace

std::vector<ReportSection> report_sections(const Json& results, bool with_thesis) {
    std::vector<ReportSection> sections;
    const auto has = [&](const char* experiment) { return results.contains(experiment); };
    if (has("equal_steps")) {
        sections.push_back(
            {"At the thesis's cost",
             "The thesis's settings cost it about two rays per pixel; here they refine most pixels "
             "to the leaves (next section). These are the figures at twice the steps of one ray "
             "per "
             "pixel, with a threshold found for each scene. A leaves missed pixels out of its "
             "kernel, A' takes them as black; both have the error-aware renderer's steps.\n\n",
             {thesis_cost_ratios_table(results["equal_steps"], with_thesis),
              thesis_cost_table(results["equal_steps"])}});
    }
    if (has("rendering")) {
        const Json& rendering = results["rendering"];
        sections.push_back(
            {"At the thesis's settings",
             "The study view in albedo, decay 0.2, threshold 0.154. Where this refines nearly all "
             "pixels, adaptive with the same steps is the reference itself, and ratios against "
             "the reference say nothing. `adaptive` (A) leaves missed pixels out of its kernel as "
             "the "
             "thesis does, `adaptive_black` (A') takes them as black; both have the normaliser "
             "with which they take the error-aware renderer's steps on that scene. "
             "`adaptive_desert` has the normaliser solved so on the desert alone, "
             "`adaptive_global` the largest variation of the four terrains, which is the thesis's "
             "normalisation taken literally.\n\n",
             {scenes_table(rendering, with_thesis), ratios_table(rendering, with_thesis),
              renderers_table(rendering, "rendering", "All renderers on the study view")}});
    }
    if (has("threshold_decay")) {
        sections.push_back(
            {"Threshold and decay", "", decay_tables(results["threshold_decay"], with_thesis)});
    }
    if (has("thresholds")) {
        sections.push_back(
            {"Thresholds", "", {thresholds_table(results["thresholds"], with_thesis)}});
    }
    if (has("equal_steps")) {
        const Json& equal = results["equal_steps"];
        sections.push_back(
            {"Error-aware against adaptive at equal steps",
             "RMSE of error-aware rendering over that of adaptive rendering; below 1 error-aware "
             "wins. Costs are in steps of one ray per pixel at its level of detail.\n\n",
             {budget_thresholds_table(equal),
              equal_steps_table(equal, "equal_steps_truth", "Study view, against the truth",
                                "truth"),
              equal_steps_table(equal, "equal_steps_reference",
                                "Study view, against the 4 × 4 reference", "reference")}});
    }
    if (has("probes")) {
        const Json& probes = results["probes"];
        sections.push_back(
            {"Light probes",
             "Cubemaps of 64² pixels per face at " + std::to_string(kProbeCount) +
                 " suggested positions per scene, errors pooled.\n\n",
             {equal_steps_table(probes, "probes_equal_steps_truth",
                                "Probes at equal steps, against the truth", "truth"),
              equal_steps_table(probes, "probes_equal_steps_reference",
                                "Probes at equal steps, against the 4 × 4 reference", "reference"),
              renderers_table(probes, "probes", "All renderers on the probes")}});
    }
    if (has("resolutions")) {
        sections.push_back({"Resolutions",
                            "With fixed levels of detail (2, 1, 0) as in the thesis, and with the "
                            "levels of the pixels.\n\n",
                            {resolutions_table(results["resolutions"], with_thesis)}});
    }
    if (has("times_of_day")) {
        sections.push_back({"Times of day",
                            "Sun and self-shadowing alone; one shadow ray per face. \"A as in "
                            "albedo\" keeps the normaliser that albedo has at equal steps.\n\n",
                            {times_table(results["times_of_day"], with_thesis)}});
    }
    if (has("beam")) {
        sections.push_back({"Cornell beam",
                            "Shadow rays from the floor to the light behind the grating; level 1, "
                            "2, 3 from 64, 128, 256 voxels on.\n\n",
                            beam_tables(results["beam"])});
    }
    if (has("shadow_rays")) {
        sections.push_back({"Shadow rays",
                            "From random points of exposed faces; a node may block where its edge "
                            "is at most cone · distance.\n\n",
                            {shadow_rays_table(results["shadow_rays"])}});
    }
    if (has("walls")) {
        sections.push_back({"Walls between lit and dark",
                            "A node is divided where it holds faces on both sides of a wall whose "
                            "light differs by more than 1 : 16; a ray is shown what is finer "
                            "there. A low sun, a dim sky.\n\n",
                            walls_tables(results["walls"])});
    }
    if (has("thin")) {
        sections.push_back({"Slackline and torch", "", {thin_table(results["thin"])}});
    }
    return sections;
}

}  // namespace probebake::study
