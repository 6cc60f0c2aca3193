// probebake serve: the service, until SIGTERM or SIGINT.
#include <arpa/inet.h>
#include <pthread.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <iostream>
#include <memory>
#include <thread>

#include "commands/commands.h"
#include "commands/local_job.h"
#include "io/file.h"
#include "log.h"
#include "service.h"

namespace probebake {
namespace {

/// A scene that still loads when all else is done is not waited for any longer than this.
constexpr std::chrono::seconds kEndTime{2};

struct ServeOptions {
    ServiceOptions service;
    SceneOptions scenes;
    bool expose = false;
    std::vector<std::string> allow_hosts;
    double drain_seconds = 10.0;
    uint64_t keep_gib = 16;
    uint64_t keep_days = 30;
    uint64_t min_free_mib = 64;
    uint64_t cache_gib = 64;
    uint64_t max_upload_mib = 0;
    uint64_t scene_gib = 8;
    uint64_t import_mib = 8192;
    int64_t import_seconds = 600;
    std::optional<std::filesystem::path> port_file;
    std::string config;
};

bool is_loopback(const std::string& host) {
    in_addr address{};  // and no name that only begins like one
    return host == "localhost" || host == "::1" ||
           (host.rfind("127.", 0) == 0 && ::inet_pton(AF_INET, host.c_str(), &address) == 1);
}

std::string in_url(const std::string& host) {
    return host.find(':') == std::string::npos ? host : "[" + host + "]";
}

ServiceOptions service_options(const ServeOptions& options) {
    ServiceOptions service = options.service;
    if (!service.http.socket && !is_loopback(service.http.host) && !options.expose) {
        throw std::invalid_argument(
            "--host " + service.http.host +
            " is reachable from other machines. There is no encryption, and idle connections can "
            "lock others out; without --tokens, whoever reaches the port can start and cancel "
            "bakes and fill the disk. Put the proxy of scripts/serve in front, or pass --expose "
            "and --tokens if the network is yours alone");
    }
    if (options.expose && !service.http.socket && !is_loopback(service.http.host) &&
        !service.tokens) {
        throw std::invalid_argument("--expose wants --tokens: without them, whoever reaches " +
                                    service.http.host +
                                    " could start and cancel bakes and fill the disk");
    }
    service.scenes = options.scenes.scenes;
    service.threads = options.scenes.threads;
    service.cache.tree_cache_dir = options.scenes.cache;
    service.cache.cache_bytes = options.cache_gib << 30;
    service.cache.memory_budget_bytes = options.scene_gib << 30;
    service.jobs.keep_bytes = options.keep_gib << 30;
    service.jobs.keep_time = std::chrono::hours(24 * options.keep_days);
    service.store.min_free_bytes = options.min_free_mib << 20;
    service.cache.importer = ImportProcess{
        .program = std::filesystem::read_symlink("/proc/self/exe"),
        .scratch = service.data / "temporary",
        .limits = {options.import_mib << 20, std::chrono::seconds(options.import_seconds)}};
    service.http.guard.max_upload_bytes = options.max_upload_mib << 20;
    service.http.guard.hosts.push_back(in_url(service.http.host));
    for (const std::string& host : options.allow_hosts) {
        service.http.guard.hosts.push_back(host);
    }
    return service;
}

/// SIGTERM and SIGINT, taken by whoever waits for them: no work is done in signal handlers.
class Signals {
  public:
    /// Before any other thread is made, so that all of them inherit the mask.
    Signals() {
        sigemptyset(&set_);
        sigaddset(&set_, SIGTERM);
        sigaddset(&set_, SIGINT);
        ::pthread_sigmask(SIG_BLOCK, &set_, nullptr);
        std::signal(SIGPIPE, SIG_IGN);  // whoever read our output may have gone
    }
    /// Whether a signal came within the time.
    bool wait(std::chrono::milliseconds time) const {
        const timespec limit{time.count() / 1000, time.count() % 1000 * 1'000'000};
        return ::sigtimedwait(&set_, nullptr, &limit) > 0;
    }

  private:
    sigset_t set_{};
};

/// Ends what runs, within the grace; a second signal ends the grace.
void drain(Service& service, const Signals& signals, double grace_seconds) {
    log_event("draining", "no more jobs are taken; a second signal stops those that run");
    const std::jthread second([&](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
            if (signals.wait(std::chrono::milliseconds(50))) service.hurry();
        }
    });
    service.drain(std::chrono::milliseconds(static_cast<int64_t>(1000 * grace_seconds)));
    log_event("stopped", "drained");
}

int serve(const ServeOptions& options) {
    const ServiceOptions service_options = probebake::service_options(options);
    const Signals signals;
    if (service_options.cache.tree_cache_dir) {
        std::filesystem::create_directories(*service_options.cache.tree_cache_dir);
    }
    auto service = std::make_unique<Service>(service_options);
    for (const std::string& problem : broken_scenes(SceneLibrary(service_options.scenes))) {
        log_warning("broken-scene", problem);
    }
    if (options.port_file) {
        write_file_atomically(*options.port_file, std::to_string(service->port()) + "\n");
    }
    std::cout << "listening on "
              << (service_options.http.socket ? service_options.http.socket->string()
                                              : "http://" + in_url(service_options.http.host) +
                                                    ":" + std::to_string(service->port()))
              << std::endl;

    constexpr std::chrono::milliseconds kLook{500};
    while (!signals.wait(kLook)) {
        if (service->listening()) continue;
        log_warning("stopped", "the socket accepts no more connections");
        return 1;
    }
    drain(*service, signals, options.drain_seconds);
    const std::jthread give_up([](const std::stop_token& stop) {
        const auto end = std::chrono::steady_clock::now() + kEndTime;
        while (!stop.stop_requested()) {
            if (std::chrono::steady_clock::now() > end) std::_Exit(0);
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
    });
    service.reset();
    return 0;
}

/// Fills in what the command line left open. One `name = value` per line, the long options' names.
void read_config(CLI::App& command, const std::string& path) {
    for (const CLI::ConfigItem& item : CLI::ConfigTOML().from_file(path)) {
        CLI::Option* option =
            item.parents.empty() ? command.get_option_no_throw("--" + item.name) : nullptr;
        if (option == nullptr || item.name == "config" || item.name == "help") {
            throw CLI::ConfigError(path + ": \"" + item.fullname() + "\" is no option of serve");
        }
        if (option->count() > 0) continue;
        option->add_result(item.inputs);
        option->run_callback();
    }
}

}  // namespace

void add_serve_command(CLI::App& app, CommandWork& work) {
    auto* command = app.add_subcommand("serve", "Run the service (docs/service.md)");
    const auto options = std::make_shared<ServeOptions>();
    HttpServer::Options& http = options->service.http;
    JobManager::Options& jobs = options->service.jobs;
    command->add_option("--host", http.host, "Address to listen on")->capture_default_str();
    command->add_option("--port", http.port, "Port; 0 picks a free one")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    command->add_option("--socket", http.socket, "Unix socket to listen on, instead of a port");
    command->add_option("--data", options->service.data, "Folder of the jobs' files")
        ->capture_default_str();
    options->scenes.add_to(*command);
    command->add_option("--scene-gib", options->scene_gib, "Memory for loaded scenes, GiB")
        ->check(CLI::Range(0, 1 << 20))
        ->capture_default_str();
    command->add_option("--cache-gib", options->cache_gib, "Files of --cache to keep, GiB")
        ->check(CLI::Range(0, 1 << 20))
        ->capture_default_str();
    command
        ->add_option("--import-mib", options->import_mib,
                     "Memory of a process that imports a scene, MiB")
        ->check(CLI::Range(64, 1 << 30))
        ->capture_default_str();
    command
        ->add_option("--import-seconds", options->import_seconds,
                     "Time of a process that imports a scene")
        ->check(CLI::Range(1, 1 << 30))
        ->capture_default_str();
    command
        ->add_option("--max-upload-mib", options->max_upload_mib,
                     "Largest scene that clients may bring, MiB; 0: they may bring none")
        ->check(CLI::Range(0, 1 << 20))
        ->capture_default_str();
    command->add_option("--max-running", jobs.max_running, "Jobs that bake at once")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    command->add_option("--max-queued", jobs.max_queued, "Jobs that may wait")
        ->check(CLI::Range(1, 10000))
        ->capture_default_str();
    command->add_option("--keep-jobs", jobs.keep_jobs, "Finished jobs to remember")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command->add_option("--keep-gib", options->keep_gib, "Files of finished jobs to keep, GiB")
        ->check(CLI::Range(0, 1 << 20))
        ->capture_default_str();
    command->add_option("--keep-days", options->keep_days, "Days that finished jobs are kept")
        ->check(CLI::Range(0, 100000))
        ->capture_default_str();
    command
        ->add_option("--max-per-tenant", jobs.max_per_tenant, "Jobs of one tenant that wait or run")
        ->check(CLI::Range(1, 10000))
        ->capture_default_str();
    command
        ->add_option("--min-free-mib", options->min_free_mib,
                     "Free disk below which no job is taken, MiB")
        ->check(CLI::Range(0, 1 << 30))
        ->capture_default_str();
    command
        ->add_option("--poison-after", options->service.store.poison_after,
                     "Ends of the service under a probe that make the probe fail")
        ->check(CLI::Range(1, 1 << 30))
        ->capture_default_str();
    command
        ->add_option(
            "--drain-seconds", options->drain_seconds,
            "Time that running jobs and answers get after SIGTERM before they are stopped (answers "
            "and uploads: at most 30)")
        ->check(CLI::Range(0.0, 86400.0))
        ->capture_default_str();
    command->add_option("--tokens", options->service.tokens,
                        "File of tokens (probebake token); without it, no token is asked for");
    command->add_option("--allow-host", options->allow_hosts,
                        "Further host name that clients may address (repeatable)");
    command->add_flag("--expose", options->expose, "Allow an address that others can reach");
    command->add_option("--port-file", options->port_file, "Write the port to this file");
    command->add_option("--config", options->config, "File of options (configs/server.toml)");
    command->callback([command, options, &work] {
        if (!options->config.empty()) read_config(*command, options->config);
        work = [options] { return serve(*options); };
    });
}

}  // namespace probebake
