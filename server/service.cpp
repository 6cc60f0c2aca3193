#include "service.h"

#include "log.h"

namespace probebake {
namespace {

JobManager::Options with_log(JobManager::Options options) {
    options.on_change = log_job;
    return options;
}

}  // namespace

Service::Service(const ServiceOptions& options)
    : scenes_(options.scenes),
      store_(options.data),
      pool_(options.threads),
      cache_(pool_, options.cache),
      jobs_(
          pool_, store_,
          [this](const SceneFile& file, const CancelToken& cancel) {
              return cache_.get(file, cancel);
          },
          options.log_requests ? with_log(options.jobs) : options.jobs),
      api_({.jobs = jobs_,
            .store = store_,
            .scenes = scenes_,
            .load = [this](const SceneFile& file,
                           const CancelToken& cancel) { return cache_.get(file, cancel); },
            .on_pool = [this](const std::function<void()>& work) { pool_.run(work); },
            .threads = options.threads,
            .max_body_bytes = options.http.guard.max_body_bytes}),
      http_(
          options.http,
          [this](const httplib::Request& request, httplib::Response& response) {
              api_.handle(request, response);
          },
          options.log_requests ? HttpServer::Log(log_request)
                               : HttpServer::Log([](const RequestLog&) {})) {}

Service::~Service() { drain(std::chrono::milliseconds(0)); }

void Service::drain(std::chrono::milliseconds grace) {
    jobs_.drain(grace);
    http_.stop();
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
