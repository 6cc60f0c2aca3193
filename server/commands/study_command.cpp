// probebake study NAME: what the documents behind this renderer say, recomputed.
#include <charconv>
#include <cmath>
#include <iostream>
#include <memory>
#include <vector>

#include "commands/commands.h"
#include "error/error_study.h"
#include "io/json.h"

namespace probebake {
namespace {

struct ErrorTableOptions {
    bool csv = false;
    bool json = false;
    std::vector<int> masks;
    std::vector<std::string> directions;  // as typed
    std::vector<Vec3> unit_directions;
};

/// How far the length of a direction may be off for want of digits: "0.58,0.58,0.58".
constexpr double kTypedUnit = 0.01;

/// "0,0.6,-0.8", scaled to unit length where few digits left it near that.
Vec3 parse_direction(const std::string& text) {
    Vec3 d(0.0);
    const char* at = text.data();
    const char* const end = at + text.size();
    for (int axis = 0; axis < 3; ++axis) {
        const auto [rest, error] = std::from_chars(at, end, d[axis]);
        const bool last = axis == 2;
        if (error != std::errc() || (last ? rest != end : rest == end || *rest != ',')) {
            throw CLI::ValidationError("--direction", "expected X,Y,Z, not " + text);
        }
        at = last ? rest : rest + 1;
    }
    const double length = glm::length(d);
    if (!(std::abs(length - 1.0) <= kTypedUnit)) {
        throw CLI::ValidationError("--direction", "expected unit length, not " + text);
    }
    return std::abs(length - 1.0) < 1e-12 ? d : d / length;
}

Json write_deviation(const Deviation& deviation) {
    return {{"mean", deviation.mean}, {"rms", deviation.rms}, {"max", deviation.max}};
}

Json write_accuracy(const ErrorAccuracy& accuracy) {
    Json json;
    for (const auto& frame : accuracy.frame_buffers) {
        Json row = write_deviation(frame.ray_cast);
        row["frame_px"] = frame.frame_px;
        row["thesis_bound"] = frame.thesis_bound;
        json["ray_cast"].push_back(std::move(row));
    }
    json["sh9"] = write_deviation(accuracy.sh9);
    json["sh9_between_directions"] = write_deviation(accuracy.sh9_between);
    json["sh9_lowest"] = accuracy.sh9_lowest;
    json["octant_table"] = write_deviation(accuracy.octant_table);
    json["octant_table_between_directions"] = write_deviation(accuracy.octant_table_between);
    return json;
}

int error_table(const ErrorTableOptions& options) {
    if (!options.csv) {
        const ErrorAccuracy accuracy = measure_error_accuracy();
        if (options.json) {
            std::cout << dump_json(write_accuracy(accuracy), 2) << '\n';
        } else {
            print_error_accuracy(std::cout, accuracy);
        }
        return 0;
    }
    ErrorRows rows;
    if (!options.masks.empty()) {
        rows.masks.clear();
        for (const int mask : options.masks) rows.masks.push_back(static_cast<uint8_t>(mask));
    }
    if (!options.unit_directions.empty()) rows.directions = options.unit_directions;
    write_error_csv(std::cout, rows);
    std::cout.flush();
    return std::cout.good() ? 0 : 1;
}

}  // namespace

void add_study_command(CLI::App& app, CommandWork& work) {
    auto* study = app.add_subcommand("study", "Recompute what the underlying documents report");
    study->require_subcommand(1);
    add_thesis_command(*study, work);
    add_beyond_command(*study, work);
    add_calibration_command(*study, work);
    add_octrees_command(*study, work);
    add_volumes_command(*study, work);
    add_stability_command(*study, work);
    auto* command = study->add_subcommand(
        "error-table",
        "Visibility error of the 256 child masks: accuracy of every table, or its values");
    const auto options = std::make_shared<ErrorTableOptions>();
    command->add_flag("--csv", options->csv,
                      "Print mask,dx,dy,dz,ray_cast,sh9,exact,octant_table instead of a summary");
    command->add_flag("--json", options->json, "Print the summary as JSON");
    command->add_option("--mask", options->masks, "Only this child mask; repeatable")
        ->check(CLI::Range(0, 255))
        ->allow_extra_args(false);
    command
        ->add_option("--direction", options->directions,
                     "Only this unit direction X,Y,Z; repeatable")
        ->allow_extra_args(false);
    command->callback([options, &work] {
        for (const std::string& text : options->directions) {
            options->unit_directions.push_back(parse_direction(text));
        }
        work = [options] { return error_table(*options); };
    });
}

}  // namespace probebake
