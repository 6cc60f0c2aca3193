#include "study/report_light.h"

#include "study/report_cells.h"

namespace probebake::study {
namespace {

std::string percent(double share) { return decimals(100.0 * share, 2) + " %"; }

}  // namespace

TextTable shadow_rays_table(const Json& experiment) {
    TextTable table{.name = "shadow_rays",
                    .title = "Steps per shadow ray; rays whose answer differs from the voxels'",
                    .columns = {"scene", "cone", "voxels", "distance", "thesis's formula",
                                "maximum over the subtree", "nodes it looked at per ray"}};
    for (const auto& [scene, result] : experiment.items()) {
        const Json& rows = result["rows"];
        for (size_t i = 0; i < rows.size(); i += 3) {
            std::vector<std::string> cells = {
                scene, "1/" + text_of(1.0 / rows[i]["cone"].get<double>()),
                decimals(result["voxel_steps_per_ray"].get<double>(), 2)};
            for (size_t m = 0; m < 3; ++m) {
                cells.push_back(decimals(rows[i + m]["steps_per_ray"].get<double>(), 2) + ", " +
                                percent(rows[i + m]["wrong"].get<double>()));
            }
            cells.push_back(decimals(rows[i + 2]["errors_per_ray"].get<double>(), 2));
            table.rows.push_back(std::move(cells));
        }
    }
    return table;
}

std::vector<TextTable> walls_tables(const Json& experiment) {
    TextTable shares{
        .name = "divided_nodes",
        .title = "Share of the nodes' face directions that are divided, by octree level",
        .columns = {"scene"}};
    constexpr int kLevels = 7;
    for (int level = 1; level <= kLevels; ++level) shares.columns.push_back(std::to_string(level));
    TextTable pictures{.name = "walls",
                       .title =
                           "Rays that are shown something finer; RMSE against 8 × 8 leaf rays "
                           "with every node's own mean, and now",
                       .columns = {"scene", "face", "shown finer", "LOD: before", "now",
                                   "hybrid, one ray: before", "now"}};
    for (const auto& [scene, result] : experiment.items()) {
        std::vector<std::string> cells = {scene};
        for (const Json& row : result["levels"]) {
            if (row["level"].get<int>() > kLevels) break;
            cells.push_back(
                percent(ratio(row["divided"].get<uint64_t>(), row["values"].get<uint64_t>())));
        }
        cells.resize(shares.columns.size(), "–");
        shares.rows.push_back(std::move(cells));
        for (const Json& row : result["rows"]) {
            std::vector<std::string> line = {scene, std::to_string(row["face_px"].get<int>()) + "²",
                                             percent(row["shown_finer"].get<double>())};
            for (const char* key :
                 {"lod_rmse_before", "lod_rmse", "hybrid_rmse_before", "hybrid_rmse"}) {
                line.push_back(decimals(row[key].get<double>(), 4));
            }
            pictures.rows.push_back(std::move(line));
        }
    }
    return {std::move(shares), std::move(pictures)};
}

}  // namespace probebake::study
