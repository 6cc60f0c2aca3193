// The real service as a process: alone on a loopback port, or on a unix socket behind nginx with
// configs/nginx.conf. What it takes of memory and files can be read off.
#pragma once

#include <gtest/gtest.h>
#include <httplib.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "io/json.h"
#include "io/sha256.h"
#include "server/net_jobs.h"
#include "server/process.h"
#include "server/raw_client.h"

namespace probebake::test {

class ServiceProcess {
  public:
    static constexpr const char* kNginx = "/usr/sbin/nginx";

    ServiceProcess(std::filesystem::path folder, bool behind_proxy,
                   const std::vector<std::string>& more = {})
        : folder_(std::move(folder)) {
        write_scenes(folder_ / "scenes");
        std::vector<std::string> args = {"serve",        "--data",    path("data"), "--scenes",
                                         path("scenes"), "--threads", "2"};
        const auto add = [&](const std::vector<std::string>& some) {
            args.insert(args.end(), some.begin(), some.end());
        };
        add(more);
        if (behind_proxy) {
            add({"--socket", path("probebake.sock")});
        } else {
            add({"--port", "0", "--port-file", path("port")});
        }
        service_.emplace(folder_ / "service", args, Process::Program{PROBEBAKE_BINARY, {}});
        wait_for(path(behind_proxy ? "probebake.sock" : "port"));
        port_ = behind_proxy ? start_proxy() : std::stoi(read_text(path("port")));
        for (int i = 0; i < 500 && get("/healthz").first != 200; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        EXPECT_EQ(get("/healthz").first, 200) << service_->err() << (proxy_ ? proxy_->err() : "");
    }

    ~ServiceProcess() {
        if (proxy_) proxy_->end();
    }
    ServiceProcess(const ServiceProcess&) = delete;
    ServiceProcess& operator=(const ServiceProcess&) = delete;

    int port() const { return port_; }
    Process& process() { return *service_; }
    bool running() { return !service_->wait(std::chrono::milliseconds(0)); }

    uint64_t resident_bytes() const {
        std::ifstream file("/proc/" + std::to_string(service_->pid()) + "/statm");
        uint64_t total = 0;
        uint64_t resident = 0;
        file >> total >> resident;
        return resident * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
    }
    size_t open_files() const {
        const std::filesystem::directory_iterator all("/proc/" + std::to_string(service_->pid()) +
                                                      "/fd");
        return static_cast<size_t>(std::distance(begin(all), end(all)));
    }

    httplib::Client client() const {
        httplib::Client client("127.0.0.1", port_);
        client.set_connection_timeout(5);
        client.set_read_timeout(120);  // a sanitized service is slow
        return client;
    }
    /// Status and body; 0 where there was no answer.
    std::pair<int, std::string> get(const std::string& target) const {
        const httplib::Result got = client().Get(target);
        return got ? std::pair(got->status, got->body) : std::pair(0, std::string());
    }
    std::optional<std::string> submit(const Json& request) const {
        const httplib::Result got = client().Post("/v1/bakes", request.dump(), "application/json");
        if (!got || got->status != 202) return std::nullopt;
        return parse_json(got->body).at("id").get<std::string>();
    }
    /// State in which it ended; "" where that took longer than this.
    std::string wait_until_ended(const std::string& id,
                                 std::chrono::seconds time = std::chrono::seconds(120)) const {
        const auto end = std::chrono::steady_clock::now() + time;
        while (std::chrono::steady_clock::now() < end) {
            const auto [status, body] = get("/v1/bakes/" + id);
            if (status == 200) {
                const Json bake = parse_json(body);
                if (bake.contains("ended_at")) return bake.at("state");
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        return "";
    }
    /// Digests of the first hundred rows' files as they are told, by name.
    std::map<std::string, std::string> digests(const std::string& id) const {
        std::map<std::string, std::string> found;
        const auto [status, body] = get("/v1/bakes/" + id + "/probes?page_size=100");
        EXPECT_EQ(status, 200);
        if (status != 200) return found;
        const Json page = parse_json(body);
        for (const Json& row : page.at("rows")) {
            for (const Json& file : row.at("files")) {
                found[row.at("probe").get<std::string>() + "/" +
                      row.at("state").get<std::string>() + "/" +
                      file.at("name").get<std::string>()] = file.at("sha256");
            }
        }
        return found;
    }

  private:
    std::string path(const std::string& name) const { return (folder_ / name).string(); }

    void wait_for(const std::string& file) {
        for (int i = 0; i < 3000 && !std::filesystem::exists(file); ++i) {
            ASSERT_TRUE(running()) << service_->err();
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    }

    int start_proxy() {
        const int port = free_port();
        std::string conf = read_text(std::string(PROBEBAKE_SOURCE_DIR) + "/configs/nginx.conf");
        const auto replace = [&](const std::string& from, const std::string& to) {
            for (size_t at = 0; (at = conf.find(from, at)) != std::string::npos; at += to.size()) {
                conf.replace(at, from.size(), to);
            }
        };
        replace("listen 127.0.0.1:8080", "listen 127.0.0.1:" + std::to_string(port));
        replace("unix:probebake.sock", "unix:" + path("probebake.sock"));
        write_text(path("nginx.conf"), conf);
        std::filesystem::create_directories(path("nginx"));
        const std::string user = ::geteuid() == 0 ? " user root;" : "";
        // In order, also if this process is killed: the workers outlive a killed master.
        proxy_.emplace(folder_ / "proxy",
                       std::vector<std::string>{"--pdeathsig", "TERM", kNginx, "-e", "stderr", "-p",
                                                folder_.string(), "-c", path("nginx.conf"), "-g",
                                                "daemon off;" + user},
                       Process::Program{"/usr/bin/setpriv", {}});
        return port;
    }

    const std::filesystem::path folder_;
    std::optional<Process> service_;
    std::optional<Process> proxy_;  // ends first
    int port_ = 0;
};

}  // namespace probebake::test
