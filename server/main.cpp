// probebake: light probes baked to a quality target. One binary, one subcommand per task.
#include <exception>
#include <iostream>

#include "commands/commands.h"
#include "io/io_error.h"
#include "io/spec_error.h"

int main(int argc, char** argv) {
    using namespace probebake;
    CLI::App app("probebake: bakes light probes of voxel worlds to a quality target");
    app.set_version_flag("--version", PROBEBAKE_VERSION);
    app.require_subcommand(1);
    CommandWork work;
    add_bake_command(app, work);
    add_check_command(app, work);
    add_client_commands(app, work);
    add_import_command(app, work);
    add_preview_command(app, work);
    add_report_command(app, work);
    add_scene_command(app, work);
    add_serve_command(app, work);
    add_study_command(app, work);
    add_token_command(app, work);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    try {
        return work();
    } catch (const std::exception& error) {
        std::cerr << "probebake: " << error.what() << '\n';
        return 1;
    }
}
