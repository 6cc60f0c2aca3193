// probebake submit, list, status, wait, download, cancel: a client of a running service.
#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include "commands/commands.h"
#include "commands/download.h"
#include "commands/report_text.h"
#include "commands/service_client.h"
#include "commands/terminal.h"
#include "io/file.h"

namespace probebake {
namespace {

struct ClientOptions {
    std::string server = "http://127.0.0.1:8080";
    bool json = false;
    std::string id;
    std::filesystem::path job;
    std::filesystem::path out;
    std::string state;
};

constexpr uint64_t kMaxJobBytes = uint64_t{1} << 26;  // the service's own limit is lower

std::string bake_path(const ClientOptions& options) { return "/v1/bakes/" + options.id; }

bool ended(const Json& bake) {
    return bake.at("state") == "SUCCEEDED" || bake.at("state") == "FAILED" ||
           bake.at("state") == "CANCELLED";
}

std::string progress_text(const Json& bake) {
    const Json& progress = bake.at("progress");
    std::string text = grouped(progress.at("units_done")) + "/" + grouped(progress.at("units"));
    if (progress.contains("seconds_left")) {
        text += ", " + fixed(progress["seconds_left"], 1) + " s left";
    }
    return text;
}

/// A bake for people: its state in one line, then what went wrong.
std::string bake_text(const Json& bake) {
    std::string text = bake.at("id").get<std::string>() + " " +
                       bake.at("state").get<std::string>() + " " + progress_text(bake) +
                       " cubemaps, " + fixed(bake["progress"].at("seconds"), 1) + " s\n";
    if (bake.contains("error")) {
        text += "error: " + bake["error"].at("detail").get<std::string>() + "\n";
        if (bake["error"].contains("errors")) {
            for (const Json& error : bake["error"]["errors"]) {
                text += "  " + error.at("pointer").get<std::string>() + ": " +
                        error.at("detail").get<std::string>() + "\n";
            }
        }
    }
    for (const Json& warning : bake.at("warnings")) {
        text += "warning: " + warning.get<std::string>() + "\n";
    }
    return text;
}

void print(const ClientOptions& options, const Json& json, const std::string& text) {
    std::cout << (options.json ? dump_json(json, 2) + "\n" : text) << std::flush;
}

int submit(const ClientOptions& options) {
    const std::vector<std::byte> bytes = read_file(options.job, kMaxJobBytes);
    const Json bake =
        ServiceClient(options.server)
            .post("/v1/bakes",
                  std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    print(options, bake, bake.at("id").get<std::string>() + "\n");
    return 0;
}

int list(const ClientOptions& options) {
    ServiceClient service(options.server);
    const std::string state = options.state.empty() ? "" : "&state=" + options.state;
    Json all = {{"bakes", Json::array()}};
    std::string token;
    do {
        const Json page = service.get("/v1/bakes?page_size=100" + state + token);
        for (const Json& bake : page.at("bakes")) all["bakes"].push_back(bake);
        token = page.contains("next_page_token")
                    ? "&page_token=" + page["next_page_token"].get<std::string>()
                    : "";
    } while (!token.empty());
    Table table({"id", "state", "cubemaps", "scene", "created"});
    for (const Json& bake : all["bakes"]) {
        table.add({bake.at("id"), bake.at("state"), progress_text(bake), bake.at("scene"),
                   bake.at("created_at")});
    }
    print(options, all, table.text());
    return 0;
}

int status(const ClientOptions& options) {
    const Json bake = ServiceClient(options.server).get(bake_path(options));
    print(options, bake, bake_text(bake));
    return 0;
}

int cancel(const ClientOptions& options) {
    const Json bake = ServiceClient(options.server).post(bake_path(options) + ":cancel");
    print(options, bake, bake_text(bake));
    return 0;
}

int wait(const ClientOptions& options) {
    constexpr std::chrono::milliseconds kFirst{50};
    constexpr std::chrono::milliseconds kLongest{1000};
    ServiceClient service(options.server);
    ProgressBar bar(options.json);
    Json bake;
    for (auto interval = kFirst;; interval = std::min(2 * interval, kLongest)) {
        bake = service.get(bake_path(options));
        const Json& progress = bake.at("progress");
        const bool rendering = progress.value("phase", "") == "rendering";
        bar.show(progress.value("phase", bake.at("state").get<std::string>()),
                 rendering ? progress.at("units_done").get<uint64_t>() : 0,
                 rendering ? progress.at("units").get<uint64_t>() : 0,
                 progress.contains("seconds_left")
                     ? std::optional<double>(progress["seconds_left"].get<double>())
                     : std::nullopt);
        if (ended(bake)) break;
        std::this_thread::sleep_for(interval);
    }
    print(options, bake, bake_text(bake));
    return bake["state"] == "SUCCEEDED" ? 0 : 1;
}

int download(const ClientOptions& options) {
    ServiceClient service(options.server);
    ProgressBar bar(options.json);
    const uint64_t units = service.get(bake_path(options)).at("progress").at("units");
    const Download done = download_bake(service, options.id, options.out, [&](uint64_t files) {
        bar.show("downloading", std::min(files, units), units, std::nullopt);
    });
    const Json summary = {{"id", options.id},    {"out", options.out.string()},
                          {"files", done.files}, {"kept", done.kept},
                          {"bytes", done.bytes}, {"complete", done.report.has_value()}};
    std::string text;
    if (done.report) {
        text = report_text(*done.report, done.rows);
    } else {
        text = "the bake has no report; these are the files that it had finished\n";
    }
    text += grouped(done.files) + " files in " + options.out.string() + ", " +
            bytes_text(done.bytes) + ", sizes and SHA-256 checked, " + grouped(done.kept) +
            " of them there before\n";
    print(options, summary, text);
    return 0;
}

using ClientWork = int (*)(const ClientOptions&);

}  // namespace

void add_client_commands(CLI::App& app, CommandWork& work) {
    const auto options = std::make_shared<ClientOptions>();
    const auto add = [&](const char* name, const char* description, ClientWork client_work) {
        CLI::App* command = app.add_subcommand(name, description);
        command->add_option("--server", options->server, "URL of the service")
            ->envname("PROBEBAKE_SERVER")
            ->capture_default_str();
        command->add_flag("--json", options->json, "Print the answer as JSON");
        command->callback(
            [options, client_work, &work] { work = [=] { return client_work(*options); }; });
        return command;
    };
    const auto with_id = [&](CLI::App* command) {
        command->add_option("id", options->id, "The bake's id, as submit printed it")->required();
        return command;
    };
    add("submit", "Have a service bake a job; prints the bake's id", submit)
        ->add_option("job", options->job, "Job file (docs/request.md)")
        ->required();
    add("list", "Bakes of a service, newest first", list)
        ->add_option("--state", options->state, "Only those in this state");
    with_id(add("status", "State and progress of a bake", status));
    with_id(add("wait", "Wait until a bake has ended; 0 only where it succeeded", wait));
    with_id(add("download", "Fetch and check a bake's files", download))
        ->add_option("--out", options->out, "Folder for cubemaps and report")
        ->required();
    with_id(add("cancel", "Cancel a bake", cancel));
}

}  // namespace probebake
