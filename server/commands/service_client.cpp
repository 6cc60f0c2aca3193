#include "commands/service_client.h"

#include <httplib.h>

#include <cstdlib>

namespace probebake {
namespace {

constexpr size_t kMaxProblemBytes = size_t{64} << 10;

/// What a refusal says, whoever wrote it: a proxy may stand in between.
std::string problem_text(int status, const std::string& body) {
    std::string text = "the service answered " + std::to_string(status);
    try {
        const Json problem = parse_json(body);
        text = problem.at("title").get<std::string>() + " (" + std::to_string(status) +
               "): " + problem.at("detail").get<std::string>();
        if (!problem.contains("errors")) return text;
        for (const Json& error : problem["errors"]) {
            const auto pointer = error.at("pointer").get<std::string>();
            text += "\n  " + (pointer.empty() ? "(document)" : pointer) + ": " +
                    error.at("detail").get<std::string>();
        }
    } catch (const std::exception&) {
        // No problem document: the status must do.
    }
    return text;
}

}  // namespace

struct ServiceClient::State {
    explicit State(const std::string& server_url) : url(server_url), http(server_url) {
        http.set_connection_timeout(5);
        http.set_read_timeout(60);
        http.set_tcp_nodelay(true);
        const char* const token = std::getenv("PROBEBAKE_TOKEN");
        if (token != nullptr) http.set_bearer_token_auth(token);
    }
    [[noreturn]] void fail(const httplib::Error& error) const {
        throw ServiceError(0, "no answer from " + url + ": " + httplib::to_string(error));
    }
    std::string document(const httplib::Result& result) const {
        if (!result) fail(result.error());
        if (result->status < 200 || result->status > 299) {
            throw ServiceError(result->status, problem_text(result->status, result->body));
        }
        return result->body;
    }

    std::string url;
    httplib::Client http;
};

ServiceClient::ServiceClient(const std::string& url) : state_(std::make_unique<State>(url)) {
    if (!state_->http.is_valid())
        throw ServiceError(0, url + " is not of the form http://HOST:PORT");
}

ServiceClient::~ServiceClient() = default;

Json ServiceClient::get(const std::string& path) {
    return parse_json(state_->document(state_->http.Get(path)));
}

Json ServiceClient::post(const std::string& path, const std::string& body) {
    return parse_json(state_->document(state_->http.Post(path, body, "application/json")));
}

void ServiceClient::download(const std::string& path,
                             const std::function<void(std::string_view)>& sink) {
    int status = 0;
    std::string problem;
    const httplib::Result result = state_->http.Get(
        path,
        [&](const httplib::Response& response) {
            status = response.status;
            return true;
        },
        [&](const char* data, size_t size) {
            if (status == 200) {
                sink({data, size});
            } else if (problem.size() < kMaxProblemBytes) {
                problem.append(data, size);
            }
            return true;
        });
    if (!result) state_->fail(result.error());
    if (status != 200) throw ServiceError(status, problem_text(status, problem));
}

}  // namespace probebake
