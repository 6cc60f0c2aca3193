#include "service.h"

#include "log.h"

namespace probebake {
namespace {

/// However long the grace of jobs is, no client holds the end up for longer.
constexpr std::chrono::milliseconds kMostAnswerTime{30'000};

}  // namespace

JobManager::Options Service::watched(const ServiceOptions& options) {
    JobManager::Options jobs = options.jobs;
    const bool log = options.log_requests;
    jobs.on_change = [this, log](const JobSnapshot& job, const std::string& cause) {
        metrics_.count_job(job);
        if (log) log_job(job, cause);
    };
    jobs.on_report = [this](const Json& report) { metrics_.count_report(report); };
    jobs.on_mend = [this, log](const std::string& id, size_t units, const std::string& cause) {
        metrics_.count_mended(units, cause.empty());
        if (log) log_mend(id, units, cause);
    };
    return jobs;
}

Service::Service(const ServiceOptions& options)
    : tokens_(options.tokens ? Tokens(*options.tokens) : Tokens()),
      store_(options.data, options.store),
      scenes_(options.scenes, store_.data().scenes()),
      uploads_(store_.data(), options.cache.importer, options.cache.tree_cache_dir),
      pool_(options.threads),
      cache_(pool_, options.cache),
      jobs_(pool_, store_, scene_source(), watched(options)),
      api_({.jobs = jobs_,
            .store = store_,
            .scenes = scenes_,
            .uploads = uploads_,
            .load = scene_source().load,
            .sky = scene_source().sky,
            .on_pool = [this](const std::function<void()>& work) { pool_.run(work); },
            .tokens = tokens_,
            .end = end_,
            .metrics = metrics_,
            .threads = options.threads,
            .max_waiting = static_cast<int>(options.http.pool.workers / 2),
            .max_body_bytes = options.http.guard.max_body_bytes,
            .max_upload_bytes = options.http.guard.max_upload_bytes,
            .min_free_bytes = options.store.min_free_bytes,
            .comment_interval = options.comment_interval,
            .events_time = options.events_time}),
      http_(
          options.http,
          [this](const httplib::Request& request, httplib::Response& response,
                 const httplib::ContentReader* upload) { api_.handle(request, response, upload); },
          [this, log = options.log_requests](const RequestLog& request) {
              metrics_.count_request(request);
              if (log) log_request(request);
          }) {}

SceneSource Service::scene_source() {
    return {.find = [this](const std::string& name) { return scenes_.find(name); },
            .load = [this](const SceneFile& file,
                           const CancelToken& cancel) { return cache_.get(file, cancel); },
            .sky = [this](const std::filesystem::path& picture,
                          const CancelToken& cancel) { return cache_.sky(picture, cancel); }};
}

Service::~Service() { drain(std::chrono::milliseconds(0)); }

void Service::drain(std::chrono::milliseconds grace) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::min(grace, kMostAnswerTime);
    jobs_.drain(grace);
    http_.drain(std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()));
    end_.cancel();
}

void Service::hurry() {
    jobs_.hurry();
    http_.hurry();
}

std::vector<std::string> broken_scenes(const SceneLibrary& scenes) {
    std::vector<std::string> problems;
    for (const std::string& name : scenes.names()) {
        try {
            scenes.find(name);
        } catch (const std::exception& error) {
            problems.push_back(name + ": " + error.what());
        }
    }
    return problems;
}

}  // namespace probebake
