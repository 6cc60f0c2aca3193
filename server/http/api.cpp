#include "http/api.h"

#include "bake/report.h"
#include "http/query.h"

namespace probebake {
namespace {

/// A scene file as clients see it; a broken one with what is wrong about it.
Json write_scene_entry(const SceneLibrary& scenes, const std::string& name) {
    try {
        const std::optional<SceneFile> file = scenes.find(name);
        if (!file) return {{"name", name}, {"error", "the scene file is gone"}};
        Json json = {{"name", name},
                     {"description", file->description},
                     {"author", file->author},
                     {"licence", file->licence},
                     {"voxel_size_m", file->voxel_size_m},
                     {"origin_m", {file->origin_m.x, file->origin_m.y, file->origin_m.z}}};
        if (file->generator) {
            json["type"] = "generator";
            json["generator"] = file->generator->name;
            json["size"] = file->generator->size;
            json["seed"] = file->generator->seed;
        } else {
            json["type"] = "vox";
        }
        return json;
    } catch (const std::exception& error) {
        return {{"name", name}, {"error", error.what()}};
    }
}

}  // namespace

Api::Api(Parts parts) : parts_(std::move(parts)) {
    add("POST", "/v1/bakes", &Api::submit);
    add("POST", "/v1/bakes:check", &Api::check);
    add("GET", "/v1/bakes", &Api::list);
    add("GET", "/v1/bakes/{id}", &Api::status);
    add("GET", "/v1/bakes/{id}/report", &Api::report);
    add("GET", "/v1/bakes/{id}/probes", &Api::rows);
    add("GET", "/v1/bakes/{id}/probes/{probe}/{state}/{file}", &Api::file);
    add("POST", "/v1/bakes/{id}:cancel", &Api::cancel);
    add("GET", "/v1/scenes", &Api::list_scenes);
    add("GET", "/v1/limits", &Api::limits);
    add("GET", "/v1/version", &Api::version);
    add("GET", "/healthz", &Api::health);
}

void Api::add(const char* method, const char* pattern, Handler handler) {
    router_.add(method, pattern);
    handlers_.push_back(handler);
}

void Api::handle(const httplib::Request& request, httplib::Response& response) {
    const Router::Match match = router_.find(request.method, request.path);
    if (match.allow.empty()) {
        throw ProblemError({.status = 404, .code = "not-found", .detail = "there is no such path"});
    }
    if (!match.route) {
        throw ProblemError({.status = 405,
                            .code = "method-not-allowed",
                            .detail = "expected a method of: " + match.allow,
                            .allow = match.allow});
    }
    (this->*handlers_[*match.route])({request, response, match.params});
}

void Api::list_scenes(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    Json scenes = Json::array();
    for (const std::string& name : parts_.scenes.names()) {
        scenes.push_back(write_scene_entry(parts_.scenes, name));
    }
    answer_json({{"scenes", std::move(scenes)}}, call.response);
}

void Api::limits(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const JobLimits job;
    const JobManager::Options& jobs = parts_.jobs.options();
    answer_json({{"probes", job.max_probes},
                 {"face_size_px", {job.min_face_size_px, job.max_face_size_px}},
                 {"texels", job.max_texels},
                 {"position_m", job.max_position_m},
                 {"audit_pixels_per_probe", job.max_audit_pixels},
                 {"rays", job.max_rays},
                 {"request_bytes", parts_.max_body_bytes},
                 {"jobs",
                  {{"running", jobs.max_running},
                   {"queued", jobs.max_queued},
                   {"kept", jobs.keep_jobs},
                   {"kept_bytes", jobs.keep_bytes}}}},
                call.response);
}

void Api::version(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    answer_json(provenance(parts_.threads), call.response);
}

void Api::health(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    answer_json({{"status", parts_.jobs.draining() ? "draining" : "ok"}}, call.response);
}

void answer_json(const Json& json, httplib::Response& response) {
    response.set_content(dump_json(json) + "\n", "application/json");
}

}  // namespace probebake
