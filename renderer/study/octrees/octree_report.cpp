#include "study/octrees/octree_report.h"

#include <cctype>
#include <cmath>

#include "io/file.h"
#include "study/octrees/octree_figures.h"
#include "study/text_table.h"

namespace probebake::study {
namespace {

bool is_tree_count(const std::string& quantity) {
    const auto tree_end = kOctreeQuantities.begin() + kTreeQuantities;
    return std::find(kOctreeQuantities.begin(), tree_end, quantity) != tree_end;
}

std::string figure_text(double figure, const std::string& quantity) {
    if (is_tree_count(quantity)) {
        return grouped_digits(static_cast<uint64_t>(std::llround(figure)));
    }
    return decimals(figure, quantity == "N_B" ? 3 : 2);
}

std::string label_of(const std::string& scene) {
    return scene == "fluid" ? "fluid (stand-in)" : scene;
}

std::string percent(double share, int count = 1) { return decimals(100.0 * share, count) + " %"; }

/// "167.20 (167.00)": ours, and what 1999 has for it.
std::string cell(const HavranTables& tables, const std::string& scene, const Json& result,
                 const Json& row, const std::string& quantity) {
    const double ours = octree_figure(result, row, quantity);
    const auto theirs = tables.value(row.at("method").get<std::string>(), scene,
                                     row.at("depth").get<int>(), quantity);
    std::string text = figure_text(ours, quantity);
    if (theirs) text += " (" + figure_text(*theirs, quantity) + ")";
    return text;
}

/// In the document's layout: scene by scene, quantities down, depths across.
TextTable method_table(const HavranTables& tables, const Json& results, const std::string& method,
                       const std::vector<int>& depths) {
    TextTable table{
        .name = method, .title = method + "; in brackets 1999", .columns = {"scene", "quantity"}};
    for (const int depth : depths) table.columns.push_back(std::to_string(depth));
    for (const auto& [scene, result] : results.items()) {
        for (const std::string quantity : kOctreeQuantities) {
            std::vector<std::string> row = {label_of(scene), quantity};
            for (const int depth : depths) {
                const Json* at = find_row(result, method, depth);
                row.push_back(at == nullptr ? "" : cell(tables, scene, result, *at, quantity));
            }
            table.rows.push_back(std::move(row));
        }
    }
    return table;
}

/// Depth with the lowest N_TR.
const Json* best_row(const Json& result, const std::string& method) {
    const Json* best = nullptr;
    for (const Json& row : result.at("rows")) {
        if (row.at("method") != method) continue;
        if (best == nullptr || row.at("trace_seconds") < best->at("trace_seconds")) best = &row;
    }
    return best;
}

std::optional<int> best_depth_1999(const HavranTables& tables, const std::string& method,
                                   const std::string& scene) {
    std::optional<int> best;
    double least = kInfinity;
    for (int depth = 4; depth <= 7; ++depth) {
        const auto seconds = tables.value(method, scene, depth, "N_TR");
        if (seconds && *seconds < least) {
            least = *seconds;
            best = depth;
        }
    }
    return best;
}

/// The document's "Octree comparison".
TextTable best_table(const HavranTables& tables, const Json& results) {
    TextTable table{.name = "best",
                    .title =
                        "Best setting per scene and method, by N_TR; in brackets 1999 at the "
                        "same depth",
                    .columns = {"scene", "quantity"}};
    for (const char* method : kOctreeMethods) table.columns.emplace_back(method);
    for (const auto& [scene, result] : results.items()) {
        std::vector<std::string> heading = {label_of(scene), "depth (1999's fastest)"};
        for (const char* method : kOctreeMethods) {
            const Json* best = best_row(result, method);
            const auto theirs = best_depth_1999(tables, method, scene);
            heading.push_back(best->at("depth").dump() + " (" +
                              (theirs ? std::to_string(*theirs) : "–") + ")");
        }
        table.rows.push_back(std::move(heading));
        for (const std::string quantity : kOctreeQuantities) {
            std::vector<std::string> row = {label_of(scene), quantity};
            for (const char* method : kOctreeMethods) {
                row.push_back(cell(tables, scene, result, *best_row(result, method), quantity));
            }
            table.rows.push_back(std::move(row));
        }
    }
    return table;
}

TextTable claims_table(const Json& summary, bool full) {
    TextTable table{.name = "claims",
                    .title = "What is asked of the figures",
                    .columns = {"asked", "found", "holds"}};
    const auto add = [&](const std::string& asked, const std::string& found, bool holds) {
        table.rows.push_back({asked, found, holds ? "yes" : "no"});
    };
    const Json& center = summary.at("center_counts");
    const auto exact = center.at("exact").get<uint64_t>();
    add("counts of centre-plane trees: 109 of 128 exact",
        std::to_string(exact) + " of " + center.at("count").dump(), exact >= 109);
    const auto largest = center.at("largest_off").get<double>();
    add("the others within 0.13 %", percent(largest, 3), largest <= 0.0013);
    if (full) {
        const auto steps = summary.at("steps_off_of_six").get<double>();
        add("N_TS of Glassner within 2 % on balls, lattice, rings, teapot, tetra, tree",
            percent(steps, 2), steps <= 0.02);
        for (const char* method : {"89", "93"}) {
            const auto off = summary.at(std::string("ratio_off_") + method).get<double>();
            add(std::string("N_TS ratio ") + method + ":84 within 0.065", decimals(off, 3),
                off <= 0.065);
        }
    }
    for (const char* method : {"cpu_89", "cpu_93", "cpu_93_cost"}) {
        const Json& cpu = summary.at(method);
        const std::string name = method + 4;
        add("less CPU time than Glassner: " +
                (name == "93_cost" ? std::string("93-A") : name + "-C"),
            cpu.at("faster").dump() + " of " + cpu.at("cases").dump() + "; " +
                decimals(cpu.at("least").get<double>(), 3) + " to " +
                decimals(cpu.at("most").get<double>(), 3) + ", median " +
                decimals(cpu.at("median").get<double>(), 3),
            cpu.at("faster") == cpu.at("cases"));
    }
    add("the walks of a tree return the same object at the same distance",
        summary.at("disagreements").dump() + " disagreements in " +
            grouped_digits(summary.at("casts").get<uint64_t>()) + " casts",
        summary.at("disagreements") == 0);
    return table;
}

TextTable rays_table(const Json& results, bool full) {
    TextTable table{.name = "rays",
                    .title = "Rays, and how many of them hit" +
                             std::string(full ? "; in brackets Havran and Sixta 1999" : ""),
                    .columns = {"scene", "eye", "hit", "secondary", "hit", "shadow", "hit"}};
    for (const auto& item : results.items()) {
        const std::string& scene = item.key();
        const Json& result = item.value();
        const auto found = std::find_if(havran_rays().begin(), havran_rays().end(),
                                        [&](const HavranRays& r) { return scene == r.scene; });
        std::vector<std::string> row = {label_of(scene)};
        const auto add = [&](const char* what, size_t kind) {
            std::string text = grouped_digits(result.at("rays").at(what).at(kind).get<uint64_t>());
            if (full && found != havran_rays().end()) {
                const auto& theirs = std::string(what) == "cast" ? found->cast : found->used;
                text += " (" + grouped_digits(theirs[kind]) + ")";
            }
            row.push_back(text);
        };
        for (size_t kind = 0; kind < 3; ++kind) {
            add("cast", kind);
            add("used", kind);
        }
        table.rows.push_back(std::move(row));
    }
    return table;
}

/// Ours and 1999's by the names of the 1999 file.
std::string values_csv(const HavranTables& tables, const Json& results, bool full) {
    std::string text = "method,scene,maxdepth,quantity,value,value_1999,comparable\n";
    for (const auto& [scene, result] : results.items()) {
        for (const Json& row : result.at("rows")) {
            for (const std::string quantity : kOctreeQuantities) {
                const auto method = row.at("method").get<std::string>();
                const int depth = row.at("depth").get<int>();
                const auto theirs = tables.value(method, scene, depth, quantity);
                text.append(method).append(",").append(scene).append(",");
                text += std::to_string(depth) + "," + quantity + "," +
                        dump_json(Json(octree_figure(result, row, quantity))) + "," +
                        (theirs ? dump_json(Json(*theirs)) : "") + "," +
                        (comparable(scene, quantity, full) ? "yes" : "no") + "\n";
            }
        }
    }
    return text;
}

std::string list_text(const std::string& title, const std::vector<std::string>& lines) {
    std::string text = "## " + title + "\n\n";
    for (const std::string& line : lines) text += "- " + line + "\n";
    return text + "\n";
}

}  // namespace

void write_octree_report(const OctreeStudyParams& params, const HavranTables& tables,
                         OctreeStudyOutcome& outcome) {
    const int size = params.measure.size_px;
    const bool full = size == kSpdSize_px;
    const std::string note = full ? "" : " (" + std::to_string(size) + " px)";
    std::string text =
        "# Octree traversals of 1999" + note +
        "\n\nV. Havran, \"Comparison of Octree Traversal Algorithms\", 1999, repeated by "
        "`probebake "
        "study octrees`. N_IT is per ray that hits, N_TS, N_ETS and N_EETS per ray; N_B and N_TR "
        "are seconds of CPU time, of casting alone here, of a Pentium II with shading there. The "
        "scene \"fluid\" was its author's own: a generated stand-in is here, which cannot be "
        "compared.\n\n";
    if (!full) {
        text += "A reduced run: its figures per ray are not comparable with those of 1999.\n\n";
    }
    for (const std::string& left : outcome.left_out) text += "Left out: " + left + "\n\n";
    std::filesystem::create_directories(params.out / "tables");
    const auto save = [&](TextTable table) {
        table.title += note;
        write_file_atomically(params.out / "tables" / (table.name + ".csv"), table.csv());
        return table.markdown();
    };
    if (!outcome.results.empty()) {
        outcome.summary = summarise_octrees(tables, outcome.results, full);
        text += save(claims_table(outcome.summary, full));
        text += save(best_table(tables, outcome.results));
        text += save(rays_table(outcome.results, full));
        for (const char* method : kOctreeMethods) {
            text += save(method_table(tables, outcome.results, method, params.measure.depths));
        }
        write_file_atomically(params.out / "octrees.csv",
                              values_csv(tables, outcome.results, full));
    }
    text += list_text("The comparison table of 1999 against its own method tables",
                      comparison_contradictions(tables));
    text += list_text("Method tables of 1999 that give one tree two counts",
                      tree_contradictions(tables));
    write_file_atomically(params.out / "report.md", text);
}

}  // namespace probebake::study
