// The API, version 1: what the service does at which path (docs/service.md has the table).
//
// The handlers translate between HTTP and the parts that do the work; they hold no state of their
// own but the counts of checks and of waiting answers.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "http/access.h"
#include "http/http_server.h"
#include "http/metrics.h"
#include "http/problem.h"
#include "http/router.h"
#include "jobs/job_manager.h"
#include "jobs/scene_uploads.h"
#include "scene/scene_library.h"

namespace probebake {

class Api {
  public:
    struct Parts {
        JobManager& jobs;
        JobStore& store;
        const SceneLibrary& scenes;
        SceneUploads& uploads;
        /// Loads a scene, or takes it from a cache.
        std::function<std::shared_ptr<const Scene>(const SceneFile&, const CancelToken&)> load;
        /// Decodes a picture of a sky.
        std::function<SkyFile(const std::filesystem::path&, const CancelToken&)> sky;
        /// Does work for a check on the render threads.
        std::function<void(const std::function<void()>&)> on_pool;
        const Tokens& tokens;
        /// Cancelled when the service ends: imports that a request has under way are given up.
        const CancelToken& end;
        Metrics& metrics;
        int threads = 1;  // of the render pool, for the version
        /// Answers that wait (long polls, events, archives) at once.
        int max_waiting = 16;
        uint64_t max_body_bytes = 0;
        uint64_t max_upload_bytes = 0;
        uint64_t min_free_bytes = 0;  // of the disk, below which nothing is taken
        /// After that much silence events have a comment; after that time they end.
        std::chrono::milliseconds comment_interval{15000};
        std::chrono::milliseconds events_time{25000};
        /// Checks that may load scenes at once, and how long one waits for its scene.
        int max_checks = 4;
        std::chrono::milliseconds check_time{20000};
    };

    explicit Api(Parts parts);
    Api(const Api&) = delete;
    Api& operator=(const Api&) = delete;

    /// Method and pattern of every path.
    static std::vector<std::pair<std::string, std::string>> route_names();
    /// Throws what http/problem.h's problem_of understands.
    void handle(const httplib::Request& request, httplib::Response& response,
                const httplib::ContentReader* upload);

  private:
    /// One request on its way through a handler.
    struct Call {
        const httplib::Request& request;
        httplib::Response& response;
        const PathParams& params;
        const Identity& who;
        const httplib::ContentReader* upload;  // of a scene's archive
    };
    using Handler = void (Api::*)(const Call&);

    struct Route {
        const char* method;
        const char* pattern;
        Scope scope;
        Handler handler;
    };
    static const std::vector<Route>& routes();
    Identity identify(const httplib::Request& request, Scope scope) const;

    // api_bakes.cpp
    void submit(const Call& call);
    void check(const Call& call);
    void list(const Call& call);
    void status(const Call& call);
    void cancel(const Call& call);
    void remove(const Call& call);
    void expire(const Call& call);
    /// Waits until the job has changed or the time is over, as `Prefer: wait` asks for. False where
    /// the job is gone: `job` is then what was seen of it last.
    bool wait_for(JobSnapshot& job, std::chrono::seconds time, bool until_ended);
    std::string etag_of(const JobSnapshot& job) const;
    /// The request of a body, read and checked, without its scene. Throws ProblemError, SpecError.
    JobRequest read_request(const Call& call) const;
    /// Throws ProblemError (404), and SpecError where the scene's file is broken.
    SceneFile find_scene(const JobSpec& spec) const;
    /// Throws ProblemError (404).
    JobSnapshot find_job(const Call& call) const;

    // api_files.cpp
    void report(const Call& call);
    void rows(const Call& call);
    void file(const Call& call);

    // api_streams.cpp
    void events(const Call& call);
    void archive(const Call& call);

    // api_scenes.cpp
    void list_scenes(const Call& call);
    void scene(const Call& call);
    void upload_scene(const Call& call);
    void remove_scene(const Call& call);
    Json describe_scene(const std::string& name) const;

    // api.cpp
    void root(const Call& call);
    void limits(const Call& call);
    void version(const Call& call);
    void health(const Call& call);
    void ready(const Call& call);
    void metrics(const Call& call);
    void openapi(const Call& call);

    const Parts parts_;
    Router router_;
    const std::string boot_id_;  // tags of an earlier run are no tags of this one
    std::shared_ptr<std::atomic<int>> checks_ = std::make_shared<std::atomic<int>>(0);
    std::shared_ptr<std::atomic<int>> uploads_ = std::make_shared<std::atomic<int>>(0);
    std::shared_ptr<std::atomic<int>> waiting_ = std::make_shared<std::atomic<int>>(0);
};

/// One of a bounded number of places; throws ServiceBusy where all are taken.
class Place {
  public:
    Place(std::shared_ptr<std::atomic<int>> taken, int most, const std::string& code);
    ~Place() { --*taken_; }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

  private:
    std::shared_ptr<std::atomic<int>> taken_;
};

/// Answers with a JSON document.
void answer_json(const Json& json, httplib::Response& response);
/// Status of a job, as documents show it.
Json write_job_status(const JobSnapshot& job);

}  // namespace probebake
