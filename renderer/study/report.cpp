#include "study/report.h"

#include "io/file.h"
#include "study/claims.h"
#include "study/plots.h"
#include "study/report_tables.h"
#include "study/thesis_check.h"

namespace probebake::study {
namespace {

std::string thesis_part() {
    std::string text = "## The thesis's tables\n\n";
    for (const std::string& finding : thesis_inconsistencies()) text += "- " + finding + "\n";
    const ThesisOwnCases own = thesis_own_cases();
    return text + "\nIts error-aware renderer's RMSE is " + decimals(own.lowest_ratio, 2) + " to " +
           decimals(own.highest_ratio, 2) + " of its adaptive renderer's in these cases, " +
           decimals(own.mean_ratio, 2) + " on average.\n\n";
}

std::string plots_part(const StudyOutcome& outcome, const std::filesystem::path& folder) {
    if (!outcome.plotted) {
        return "## Plots\n\nThere was no gnuplot, or it failed: data and scripts are in `plots`.\n";
    }
    std::string text = "## Plots\n\n";
    for (const char* name :
         {"equal_steps", "probes_equal_steps", "threshold_rays", "threshold_rmse", "decays"}) {
        if (!std::filesystem::exists(folder / (std::string(name) + ".svg"))) continue;
        text += "![" + std::string(name) + "](plots/" + name + ".svg)\n";
    }
    return text;
}

std::string pictures_part(const Json& results) {
    if (!results.contains("rendering")) return "";
    std::string text =
        "## Pictures\n\nThe study view; rays per pixel of error-aware and of adaptive rendering "
        "at twice the steps of one ray per pixel, from 1 (black) to 21 (white) on a logarithmic "
        "scale.\n\n";
    for (const auto& [scene, result] : results["rendering"].items()) {
        text += scene + ": ";
        for (const Json& picture : result["pictures"]) {
            text += "![" + picture.get<std::string>() + "](pictures/" + picture.get<std::string>() +
                    ") ";
        }
        text += "\n\n";
    }
    return text;
}

}  // namespace

void write_report(const StudyParams& params, StudyOutcome& outcome) {
    const bool full = params.size == kFullSize;
    const std::string note = full ? "" : " (size " + std::to_string(params.size) + ")";
    std::string text =
        "# The experiments of Müller 2020" + note +
        "\n\nA. Müller, \"Error-Based Adaptive Voxel Raytracing\", TUM 2020, repeated by "
        "`probebake "
        "study thesis --size " +
        std::to_string(params.size) +
        "`. Costs are counts, never seconds; the thesis's data are not public, so that ratios are "
        "compared. \"Reference\" is the thesis's, 4 × 4 leaf rays; \"truth\" 16 × 16.\n\n";
    if (!full) {
        text +=
            "A reduced run: worlds of " + std::to_string(params.size) + " voxels, views of " +
            std::to_string(params.size / 4) +
            "² pixels. Its figures are not comparable with the thesis's, which are left out.\n\n";
    }
    for (const std::string& left : outcome.left_out) text += "Left out: " + left + "\n\n";

    std::filesystem::create_directories(params.out / "tables");
    const auto save = [&](TextTable table) {
        table.title += note;
        return save_table(table, params.out);
    };
    text += "## Claims\n\n" + save(claims_table(outcome.results));
    for (const ReportSection& section : report_sections(outcome.results, full)) {
        text += "## " + section.title + note + "\n\n" + section.text;
        for (const TextTable& table : section.tables) text += save(table);
    }
    text += thesis_part();
    outcome.plotted = write_plots(params.out / "plots", outcome.results, note);
    text += plots_part(outcome, params.out / "plots");
    text += pictures_part(outcome.results);
    write_file_atomically(params.out / "report.md", text);
}

}  // namespace probebake::study
