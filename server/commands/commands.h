// The subcommands of probebake. Each adds itself to the command line; its work runs when the line
// has been parsed, and its exit code is what main returns.
//
//   0 done   1 refused or failed (the message says why)   2 the command line is wrong
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace probebake {

/// What the chosen subcommand will do.
using CommandWork = std::function<int()>;

void add_bake_command(CLI::App& app, CommandWork& work);
void add_report_command(CLI::App& app, CommandWork& work);
void add_check_command(CLI::App& app, CommandWork& work);
void add_client_commands(CLI::App& app, CommandWork& work);  // submit, list, status, wait, …
void add_import_command(CLI::App& app, CommandWork& work);
void add_preview_command(CLI::App& app, CommandWork& work);
void add_scene_command(CLI::App& app, CommandWork& work);
void add_serve_command(CLI::App& app, CommandWork& work);
void add_token_command(CLI::App& app, CommandWork& work);
void add_study_command(CLI::App& app, CommandWork& work);
void add_thesis_command(CLI::App& study_app, CommandWork& work);  // below study
void add_beyond_command(CLI::App& study_app, CommandWork& work);
void add_calibration_command(CLI::App& study_app, CommandWork& work);
void add_octrees_command(CLI::App& study_app, CommandWork& work);
void add_stability_command(CLI::App& study_app, CommandWork& work);
void add_volumes_command(CLI::App& study_app, CommandWork& work);

}  // namespace probebake
