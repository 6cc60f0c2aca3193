// Service: the parts of a running service, wired together.
//
//   HttpServer ─► Api ─► JobManager ─► run_bake on the RenderPool
//                  │         └─► SceneCache
//                  └─► JobStore, SceneLibrary
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/scene_cache.h"
#include "http/api.h"

namespace probebake {

struct ServiceOptions {
    HttpServer::Options http;
    std::filesystem::path data = "probebake-data";
    std::filesystem::path scenes = "configs/scenes";
    SceneCache::Options cache;
    int threads = 1;
    JobManager::Options jobs;
    JobStore::Options store;
    /// Who may do what; without: whoever reaches the service may do everything.
    std::optional<std::filesystem::path> tokens;
    bool log_requests = true;
    /// Of silence, before a stream of events has a comment; of a stream, before it ends.
    std::chrono::milliseconds comment_interval{15000};
    std::chrono::milliseconds events_time{25000};
};

class Service {
  public:
    /// Listens when it returns. Throws IoError where a directory cannot be used, and what
    /// HttpServer throws.
    explicit Service(const ServiceOptions& options);
    /// Stops what still runs; it goes on at the next start.
    ~Service();

    int port() const { return http_.port(); }
    bool listening() const { return http_.listening(); }
    /// Refuses new jobs, gives running ones `grace` to end, then stops them where they are, to go
    /// on at the next start; status and files are served until then. Answers and uploads that are
    /// under way in the end have what is left of the grace, 30 s of it at most, then they are cut
    /// off. Scenes that still load are not waited for here, but by the destructor.
    void drain(std::chrono::milliseconds grace);
    /// Ends the grace.
    void hurry();

  private:
    SceneSource scene_source();

    JobManager::Options watched(const ServiceOptions& options);

    Tokens tokens_;
    Metrics metrics_;
    JobStore store_;
    SceneLibrary scenes_;
    SceneUploads uploads_;
    CancelToken end_;  // of what requests have under way
    RenderPool pool_;
    SceneCache cache_;
    JobManager jobs_;
    Api api_;
    HttpServer http_;
};

/// One line of JSON per scene file that cannot be read, as the start of a service shows it.
std::vector<std::string> broken_scenes(const SceneLibrary& scenes);

}  // namespace probebake
