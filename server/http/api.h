// The API, version 1: what the service does at which path (docs/service.md has the table).
//
// The handlers translate between HTTP and the parts that do the work; they hold no state of their
// own but the count of checks under way.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "http/http_server.h"
#include "http/problem.h"
#include "http/router.h"
#include "jobs/artifact_store.h"
#include "jobs/job_manager.h"
#include "scene/scene_library.h"

namespace probebake {

class Api {
  public:
    struct Parts {
        JobManager& jobs;
        ArtifactStore& store;
        const SceneLibrary& scenes;
        SceneSource load;
        /// Does work for a check on the render threads.
        std::function<void(const std::function<void()>&)> on_pool;
        int threads = 1;  // of the render pool, for the version
        uint64_t max_body_bytes = 0;
        /// Checks that may load scenes at once, and how long one waits for its scene.
        int max_checks = 4;
        std::chrono::milliseconds check_time{20000};
    };

    explicit Api(Parts parts);
    Api(const Api&) = delete;
    Api& operator=(const Api&) = delete;

    /// Throws what http/problem.h's problem_of understands.
    void handle(const httplib::Request& request, httplib::Response& response);

  private:
    /// One request on its way through a handler.
    struct Call {
        const httplib::Request& request;
        httplib::Response& response;
        const PathParams& params;
    };
    using Handler = void (Api::*)(const Call&);

    void add(const char* method, const char* pattern, Handler handler);

    // api_bakes.cpp
    void submit(const Call& call);
    void check(const Call& call);
    void list(const Call& call);
    void status(const Call& call);
    void cancel(const Call& call);
    /// The request of a body: read, checked, its scene found. Throws ProblemError and SpecError.
    JobRequest read_request(const httplib::Request& request) const;
    /// Throws ProblemError (404).
    JobSnapshot find_job(const Call& call) const;

    // api_files.cpp
    void report(const Call& call);
    void rows(const Call& call);
    void file(const Call& call);

    // api.cpp
    void list_scenes(const Call& call);
    void limits(const Call& call);
    void version(const Call& call);
    void health(const Call& call);

    const Parts parts_;
    Router router_;
    std::vector<Handler> handlers_;
    std::atomic<int> checks_{0};
};

/// Answers with a JSON document.
void answer_json(const Json& json, httplib::Response& response);
/// Status of a job, as documents show it.
Json write_job_status(const JobSnapshot& job);

}  // namespace probebake
