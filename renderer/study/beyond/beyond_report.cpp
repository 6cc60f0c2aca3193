#include "study/beyond/beyond_report.h"

#include <algorithm>
#include <cmath>

#include "io/file.h"
#include "study/beyond/scene_comparison.h"
#include "study/text_table.h"

namespace probebake::study {
namespace {

/// A mean of ratios, and the worst of them.
class Ratios {
  public:
    void add(double ratio) {
        log_sum_ += std::log(ratio);
        worst_ = std::max(worst_, ratio);
        ++count_;
    }
    Json json() const {
        if (count_ == 0) return nullptr;
        return {{"mean", std::exp(log_sum_ / count_)}, {"worst", worst_}, {"scenes", count_}};
    }

  private:
    double log_sum_ = 0.0;
    double worst_ = 0.0;
    int count_ = 0;
};

double hybrid_rmse(const Json& row) { return row["hybrid"]["rmse"].get<double>(); }
double ratio_to(const Json& row, const char* renderer) {
    return hybrid_rmse(row) / row[renderer].get<double>();
}
double steps_ratio(const Json& set) {
    const Json& same = set["same_error"];
    return same["hybrid"]["steps"].get<double>() / same["thesis_steps"].get<double>();
}

std::string times(double budget) { return decimals(budget, 1) + " ×"; }

TextTable rmse_table(const Json& results, const char* set, const char* renderer) {
    TextTable table{.name = std::string(set) + "_" + renderer,
                    .title = std::string("RMSE over that of ") + renderer + ", " + set,
                    .columns = {"scene"}};
    for (const double budget : kBeyondBudgets) table.columns.push_back(times(budget));
    for (const auto& [scene, result] : results.items()) {
        std::vector<std::string> row = {scene};
        for (const Json& at : result[set]["rows"])
            row.push_back(decimals(ratio_to(at, renderer), 3));
        table.rows.push_back(std::move(row));
    }
    return table;
}

TextTable cost_table(const Json& results) {
    TextTable table{
        .name = "same_error",
        .title = "Steps to reach the thesis's RMSE at 4 × base, over the fewest it needs",
        .columns = {"scene", "nadir", "probes", "box tests per ray, probes", "seconds, probes",
                    "seconds without start lists", "SH9 irradiance error", "its steps / base"}};
    for (const auto& [scene, result] : results.items()) {
        const Json& reached = result["probes"]["same_error"]["hybrid"];
        table.rows.push_back(
            {scene, decimals(steps_ratio(result["nadir"]), 3),
             decimals(steps_ratio(result["probes"]), 3),
             decimals(reached["box_tests"].get<double>() / reached["rays"].get<double>(), 1),
             decimals(result["time"]["hybrid_over_thesis"].get<double>(), 3),
             decimals(result["time"]["without_lists_over_thesis"].get<double>(), 3),
             decimals(result["irradiance"]["error"].get<double>(), 4),
             decimals(result["irradiance"]["steps_per_base"].get<double>(), 2)});
    }
    return table;
}

TextTable ablation_table(const Json& results) {
    TextTable table{.name = "ablation",
                    .title = "RMSE over the thesis's, probes, geometric means",
                    .columns = {"variant", "2 ×", "4 ×"}};
    std::vector<std::pair<std::string, std::array<Ratios, 2>>> variants;
    for (const auto& [scene, result] : results.items()) {
        const Json& rows = result["probes"]["rows"];
        size_t i = 0;
        for (const Json& row : result["ablation"]) {
            if (variants.size() <= i) variants.push_back({row["variant"].get<std::string>(), {}});
            variants[i].second[0].add(row["rmse_2"].get<double>() /
                                      rows[1]["error_aware"].get<double>());
            variants[i].second[1].add(row["rmse_4"].get<double>() /
                                      rows[3]["error_aware"].get<double>());
            ++i;
        }
    }
    for (const auto& [name, ratios] : variants) {
        table.rows.push_back({name, decimals(ratios[0].json()["mean"].get<double>(), 3),
                              decimals(ratios[1].json()["mean"].get<double>(), 3)});
    }
    return table;
}

TextTable summary_table(const Json& summary) {
    TextTable table{.name = "summary",
                    .title = "Geometric means over the judged scenes, and the worst scene",
                    .columns = {"figure", "nadir", "worst", "probes", "worst"}};
    for (const auto& [figure, nadir] : summary["nadir"].items()) {
        const Json& probes = summary["probes"][figure];
        table.rows.push_back({figure, decimals(nadir["mean"].get<double>(), 3),
                              decimals(nadir["worst"].get<double>(), 3),
                              decimals(probes["mean"].get<double>(), 3),
                              decimals(probes["worst"].get<double>(), 3)});
    }
    return table;
}

std::string model_text(const ErrorModel& model) {
    std::string text = "```\n";
    for (const auto& stage : model) {
        for (const double a : stage) text += decimals(a, 6) + " ";
        text += '\n';
    }
    return text + "```\n\n";
}

}  // namespace

Json summarise(const Json& results) {
    Json summary = Json::object();
    for (const char* set : {"nadir", "probes"}) {
        for (size_t i = 0; i < kBeyondBudgets.size(); ++i) {
            for (const char* renderer : {"error_aware", "adaptive", "adaptive_black"}) {
                Ratios ratios;
                for (const auto& [scene, result] : results.items()) {
                    ratios.add(ratio_to(result[set]["rows"][i], renderer));
                }
                summary[set][std::string("rmse over ") + renderer + ", " +
                             times(kBeyondBudgets[i])] = ratios.json();
            }
        }
        Ratios steps;
        for (const auto& [scene, result] : results.items()) steps.add(steps_ratio(result[set]));
        summary[set]["steps for the thesis's rmse at 4 ×"] = steps.json();
    }
    Ratios irradiance;
    Ratios seconds;
    for (const auto& [scene, result] : results.items()) {
        irradiance.add(result["irradiance"]["error"].get<double>());
        seconds.add(result["time"]["hybrid_over_thesis"].get<double>());
    }
    summary["irradiance"] = irradiance.json();
    summary["seconds"] = seconds.json();
    return summary;
}

void write_beyond_report(const BeyondParams& params, BeyondOutcome& outcome) {
    const bool full = params.size == kFullSize;
    const std::string note = full ? "" : " (size " + std::to_string(params.size) + ")";
    std::string text = "# The default renderer beside those of Müller 2020" + note +
                       "\n\nBy `probebake study beyond --size " + std::to_string(params.size) +
                       " --probes " + std::to_string(params.probes) +
                       "`. Costs are octree steps in units of one ray per pixel at its level of "
                       "detail (base), start lists included; errors are against 256 leaf rays per "
                       "pixel.\n\n";
    for (const std::string& left : outcome.left_out) text += "Left out: " + left + "\n\n";
    std::filesystem::create_directories(params.out / "tables");
    const auto save = [&](TextTable table) {
        table.title += note;
        write_file_atomically(params.out / "tables" / (table.name + ".csv"), table.csv());
        return table.markdown();
    };
    if (!outcome.results.empty()) {
        outcome.summary = summarise(outcome.results);
        text += "## Summary" + note + "\n\n" + save(summary_table(outcome.summary));
        for (const char* set : {"nadir", "probes"}) {
            text += "## " + std::string(set) + note + "\n\n";
            for (const char* renderer : {"error_aware", "adaptive", "adaptive_black"}) {
                text += save(rmse_table(outcome.results, set, renderer));
            }
        }
        text += "## Cost" + note + "\n\n" + save(cost_table(outcome.results));
        text += "## What each part brings" + note + "\n\n" + save(ablation_table(outcome.results));
    }
    if (outcome.fitted) {
        text += "## The error model, fitted anew\n\n" + model_text(*outcome.fitted) +
                "In the renderer:\n\n" + model_text(kErrorModel);
    }
    write_file_atomically(params.out / "report.md", text);
}

}  // namespace probebake::study
