#include "commands/report_text.h"

#include "commands/terminal.h"

namespace probebake {
namespace {

std::string number_or_dash(const Json& value, int decimals) {
    return value.is_number() ? fixed(value.get<double>(), decimals) : "-";
}

/// The metric that a target is shown by: its own, or "psnr_db" for those that dB say.
std::string shown_metric(const std::string& target) {
    const bool by_itself = target == "irradiance_rel" || target == "rel_mse" || target == "ssim";
    return by_itself ? target : "psnr_db";
}

/// A metric's figure with its interval, e.g. "41.2 [40.3, 42.4]".
std::string error_text(const Json& error, const std::string& metric) {
    if (!error.contains(metric)) return "-";
    const int decimals = metric == "psnr_db" ? 1 : 4;
    const Json& interval = error[metric + "_interval"];
    return number_or_dash(error[metric], decimals) + " [" + number_or_dash(interval[0], decimals) +
           ", " + number_or_dash(interval[1], decimals) + "]";
}

std::string settings_text(const Json& settings) {
    std::string text = settings["renderer"];
    if (settings.contains("threshold")) text += " " + fixed(settings["threshold"], 3);
    if (settings.contains("leaf_grid")) {
        const std::string grid = std::to_string(settings["leaf_grid"].get<int>());
        text += " " + grid + "x" + grid;
    }
    if (settings.contains("noise")) {
        text += " " + std::to_string(settings["samples"].get<int>()) + "+, noise " +
                fixed(settings["noise"], 4);
    }
    if (settings.contains("spread")) text += " spread " + fixed(settings["spread"], 3);
    return text;
}

}  // namespace

std::string report_text(const Json& report, const std::vector<Json>& rows) {
    const Json& scene = report["scene"];
    const Json& target = report["target"];
    const Json& targets = target["targets"];
    const std::string metric = shown_metric(targets[0]["metric"]);
    std::string wanted;
    for (const Json& one : targets) {
        if (!wanted.empty()) wanted += target["require"] == "all" ? " and " : " or ";
        wanted += one["metric"].get<std::string>() + " " + one["value"].dump();
    }
    std::string text = "scene " + scene["name"].get<std::string>() + ": " +
                       grouped(scene["voxels"]) + " voxels, " + grouped(scene["octree_nodes"]) +
                       " octree nodes, " + bytes_text(scene["bytes"]) + "\ntarget " + wanted +
                       " against " + target["against"].get<std::string>() + "\n\n";

    Table table({"probe/state", "result", "evidence", metric == "psnr_db" ? "dB" : metric,
                 "rays/px", "rays", "steps", "seconds", "settings"});
    for (const Json& row : rows) {
        if (row.contains("grid")) continue;
        const Json& cost = row["cost"];
        const uint64_t rays = cost["render"]["rays"].get<uint64_t>() +
                              cost["render"]["discarded_rays"].get<uint64_t>();
        table.add(
            {row["probe"].get<std::string>() + "/" + row["state"].get<std::string>(), row["result"],
             row["evidence"], row.contains("error") ? error_text(row["error"], metric) : "-",
             fixed(cost["rays_per_pixel"], 2), grouped(rays), grouped(cost["render"]["steps"]),
             fixed(cost["render"]["seconds"], 3), settings_text(row["settings"])});
    }
    text += table.text() + "\n";

    for (const Json& state : report["states"]) {
        if (state.contains("media")) {
            text += state["state"].get<std::string>() + ": tracker " +
                    state["media"]["tracker"].get<std::string>() + " (" +
                    state["media"]["reason"].get<std::string>() + ")\n";
        }
        const Json& cost = state["cost"];
        text += state["state"].get<std::string>() + ": ";
        if (state.contains("error"))
            text += "all probes " + error_text(state["error"], metric) + ", ";
        text += "pilot " + fixed(100.0 * cost["pilot_steps_over_render"].get<double>(), 1) +
                " % and audit " + fixed(100.0 * cost["audit_steps_over_render"].get<double>(), 1) +
                " % of the render's steps\n";
    }
    const Json& totals = report["totals"];
    text += "wall " + fixed(totals["wall_seconds"], 2) + " s, scene loaded in " +
            fixed(scene["load"]["seconds"], 2) + " s, peak memory " +
            bytes_text(totals["peak_memory_bytes"]) + "\n";
    for (const Json& warning : report["warnings"]) {
        text += "warning: " + warning.get<std::string>() + "\n";
    }
    return text;
}

}  // namespace probebake
