// probebake token: makes a token and its entry for the service's file of tokens.
#include <iostream>

#include "commands/commands.h"
#include "http/access.h"

namespace probebake {

void add_token_command(CLI::App& app, CommandWork& work) {
    struct Options {
        std::string tenant;
        std::vector<std::string> scopes = {"submit", "read"};
        std::string expires_at;
    };
    auto* command =
        app.add_subcommand("token", "Make a token for the service (docs/service.md, Access)");
    const auto options = std::make_shared<Options>();
    command->add_option("--tenant", options->tenant, "Whose it is")->required();
    command->add_option("--scopes", options->scopes, "What it is for: submit, read, metrics, admin")
        ->delimiter(',')
        ->capture_default_str();
    command->add_option("--expires-at", options->expires_at, "A time like 2027-01-31T00:00:00Z");
    command->callback([options, &work] {
        work = [options] {
            const std::string token = new_token();
            const Json entry =
                write_token_entry(token, options->tenant, options->scopes, options->expires_at);
            // The token is shown once; the service keeps its digest.
            std::cout << token << '\n' << dump_json(entry) << '\n';
            return 0;
        };
    });
}

}  // namespace probebake
