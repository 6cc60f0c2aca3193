// A service in this process, on a free port, with a small scene library; and how to talk to it.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "net_jobs.h"
#include "openapi_check.h"
#include "service.h"
#include "support/sanitized.h"

namespace probebake::test {

struct Answer {
    int status = 0;
    std::string body;
    httplib::Headers headers;

    Json json() const { return parse_json(body); }
    std::string header(const std::string& name) const {
        const auto at = headers.find(name);
        return at == headers.end() ? "" : at->second;
    }
};

class RunningService {
  public:
    using Change = std::function<void(ServiceOptions&)>;
    explicit RunningService(const Change& change = {}) {
        options_.http.port = 0;
        options_.data = folder_.path() / "data";
        options_.scenes = folder_.path() / "scenes";
        options_.threads = 2;
        options_.log_requests = false;
        write_scenes(options_.scenes);
        if (change) change(options_);
        start();
    }

    Service& operator*() { return *service_; }
    int port() const { return service_->port(); }
    const ServiceOptions& options() const { return options_; }
    std::string url() const { return "http://127.0.0.1:" + std::to_string(port()); }
    void restart() {
        service_.reset();
        start();
    }
    void stop() { service_.reset(); }

    Answer get(const std::string& path, const httplib::Headers& headers = {}) const {
        return answer("GET", path, client().Get(path, headers));
    }
    Answer post(const std::string& path, const std::string& body = {},
                const char* type = "application/json") const {
        return taken(path, body,
                     answer("POST", path,
                            body.empty() ? client().Post(path) : client().Post(path, body, type)));
    }
    Answer post(const std::string& path, const httplib::Headers& headers, const Json& body) const {
        const std::string text = body.dump();
        return taken(path, text,
                     answer("POST", path, client().Post(path, headers, text, "application/json")));
    }
    Answer put(const std::string& path, const httplib::Headers& headers, const std::string& body,
               const char* type) const {
        return answer("PUT", path, client().Put(path, headers, body, type));
    }
    Answer remove(const std::string& path, const httplib::Headers& headers = {}) const {
        return answer("DELETE", path, client().Delete(path, headers));
    }
    Answer post(const std::string& path, const Json& body) const { return post(path, body.dump()); }
    const std::filesystem::path& scenes() const { return options_.scenes; }
    httplib::Client client() const {
        httplib::Client client(url());
        client.set_read_timeout(120);  // beyond the 30 s that a client may have the service wait
        return client;
    }

    /// The id of an accepted job.
    std::string submit(const Json& request) const {
        const Answer taken = post("/v1/bakes", request);
        EXPECT_EQ(taken.status, 202) << taken.body;
        return taken.status == 202 ? taken.json().at("id").get<std::string>() : "";
    }
    Json status(const std::string& id) const { return get("/v1/bakes/" + id).json(); }
    std::string state(const std::string& id) const { return status(id).at("state"); }
    uint64_t units_done(const std::string& id) const {
        return status(id).at("progress").at("units_done");
    }
    /// Until `reached` says so, at most this long; the status then.
    Json wait(const std::string& id, const std::function<bool(const Json&)>& reached,
              std::chrono::seconds at_most = patient(std::chrono::seconds(300))) const {
        const auto end = std::chrono::steady_clock::now() + at_most;
        for (;;) {
            Json now = status(id);
            if (reached(now)) return now;
            if (std::chrono::steady_clock::now() > end) {
                ADD_FAILURE() << "waited too long: " << now.dump();
                return now;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    }
    Json wait_until_ended(const std::string& id) const {
        return wait(id, [](const Json& bake) { return bake.contains("ended_at"); });
    }
    std::string bake(const Json& request) const {
        std::string id = submit(request);
        const Json ended = wait_until_ended(id);
        EXPECT_EQ(ended.at("state"), "SUCCEEDED") << ended.dump();
        return id;
    }

  private:
    void start() { service_ = std::make_unique<Service>(options_); }
    static Answer answer(const std::string& method, const std::string& path,
                         const httplib::Result& result) {
        if (!result) {
            ADD_FAILURE() << "no answer: " << httplib::to_string(result.error());
            return {};
        }
        std::set<std::string> headers;
        for (const auto& [name, value] : result->headers) headers.insert(name);
        expect_described(method, path, result->status, result->get_header_value("Content-Type"),
                         result->body, headers);
        return {result->status, result->body, result->headers};
    }
    static Answer taken(const std::string& path, const std::string& body, Answer answer) {
        if (!body.empty() && answer.status < 300) expect_described_request("POST", path, body);
        return answer;
    }

    TempFolder folder_;
    ServiceOptions options_;
    std::unique_ptr<Service> service_;
};

/// Wall time of a piece of work.
inline double seconds_of(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace probebake::test
