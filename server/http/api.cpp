#include "http/api.h"

#include "bake/report.h"
#include "http/openapi.h"
#include "http/query.h"

namespace probebake {

const std::vector<Api::Route>& Api::routes() {
    static const std::vector<Route> all = {
        {"POST", "/v1/bakes", Scope::kSubmit, &Api::submit},
        {"POST", "/v1/bakes:check", Scope::kSubmit, &Api::check},
        {"POST", "/v1/bakes:expire", Scope::kAdmin, &Api::expire},
        {"GET", "/v1/bakes", Scope::kRead, &Api::list},
        {"GET", "/v1/bakes/{id}", Scope::kRead, &Api::status},
        {"DELETE", "/v1/bakes/{id}", Scope::kSubmit, &Api::remove},
        {"POST", "/v1/bakes/{id}:cancel", Scope::kSubmit, &Api::cancel},
        {"GET", "/v1/bakes/{id}/events", Scope::kRead, &Api::events},
        {"GET", "/v1/bakes/{id}/report", Scope::kRead, &Api::report},
        {"GET", "/v1/bakes/{id}/archive.tar", Scope::kRead, &Api::archive},
        {"GET", "/v1/bakes/{id}/probes", Scope::kRead, &Api::rows},
        {"GET", "/v1/bakes/{id}/probes/{probe}/{state}/{file}", Scope::kRead, &Api::file},
        {"GET", "/v1/scenes", Scope::kRead, &Api::list_scenes},
        {"GET", "/v1/scenes/{name}", Scope::kRead, &Api::scene},
        {"PUT", "/v1/scenes/{name}", Scope::kAdmin, &Api::upload_scene},
        {"DELETE", "/v1/scenes/{name}", Scope::kAdmin, &Api::remove_scene},
        {"GET", "/", Scope::kOpen, &Api::root},
        {"GET", "/v1/limits", Scope::kOpen, &Api::limits},
        {"GET", "/v1/version", Scope::kOpen, &Api::version},
        {"GET", "/openapi.json", Scope::kOpen, &Api::openapi},
        {"GET", "/healthz", Scope::kOpen, &Api::health},
        {"GET", "/readyz", Scope::kOpen, &Api::ready},
        {"GET", "/metrics", Scope::kMetrics, &Api::metrics},
    };
    return all;
}

std::vector<std::pair<std::string, std::string>> Api::route_names() {
    std::vector<std::pair<std::string, std::string>> names;
    for (const Route& route : routes()) names.emplace_back(route.method, route.pattern);
    return names;
}

Api::Api(Parts parts) : parts_(std::move(parts)), boot_id_(new_job_id().substr(2, 8)) {
    for (const Route& route : routes()) router_.add(route.method, route.pattern);
}

Identity Api::identify(const httplib::Request& request, Scope scope) const {
    constexpr unsigned kAll = ~0U;
    if (!parts_.tokens.required()) return {kNoTenant, kAll};
    if (scope == Scope::kOpen) return {"", 0};
    const std::optional<Identity> who =
        parts_.tokens.find(request.get_header_value("Authorization"), rfc3339(unix_ms_now()));
    if (!who) {
        throw ProblemError({.status = 401,
                            .code = "unauthorized",
                            .detail = "expected \"Authorization: Bearer\" with a token that holds",
                            .authenticate = true});
    }
    if (!who->may(scope)) {
        throw ProblemError(
            {.status = 403, .code = "forbidden", .detail = "the token does not hold for this"});
    }
    return *who;
}

void Api::handle(const httplib::Request& request, httplib::Response& response,
                 const httplib::ContentReader* upload) {
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
    const Route& route = routes()[*match.route];
    const Identity who = identify(request, route.scope);
    (this->*route.handler)({request, response, match.params, who, upload});
}

void Api::root(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    Json paths = Json::array();
    for (const auto& [method, pattern] : route_names()) {
        paths.push_back(std::string(method).append(" ").append(pattern));
    }
    answer_json({{"service", "probebake"},
                 {"version", provenance(parts_.threads).at("version")},
                 {"paths", std::move(paths)}},
                call.response);
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
                 {"upload_bytes", parts_.max_upload_bytes},
                 {"jobs",
                  {{"running", jobs.max_running},
                   {"queued", jobs.max_queued},
                   {"kept", jobs.keep_jobs},
                   {"kept_bytes", jobs.keep_bytes},
                   {"kept_seconds", jobs.keep_time.count()},
                   {"per_tenant", jobs.max_per_tenant},
                   {"idempotency_key_seconds", jobs.key_time.count()}}}},
                call.response);
}

void Api::version(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    Json version = provenance(parts_.threads);
    version.erase("cpu");  // whoever may ask
    answer_json(version, call.response);
}

void Api::health(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    answer_json({{"status", parts_.jobs.draining() ? "draining" : "ok"}}, call.response);
}

void Api::ready(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const bool draining = parts_.jobs.draining();
    const bool room = parts_.store.has_room();
    const bool writable = parts_.store.data().is_writable();
    const bool ready = !draining && room && writable;
    if (!ready) call.response.status = 503;
    answer_json({{"ready", ready},
                 {"draining", draining},
                 {"disk_has_room", room},
                 {"database_writable", writable}},
                call.response);
}

void Api::openapi(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const std::string_view text = openapi_text();
    call.response.set_content(text.data(), text.size(), "application/json");
}

void Api::metrics(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    call.response.set_content(parts_.metrics.scrape(parts_.jobs, parts_.store),
                              "text/plain; version=0.0.4");
}

Place::Place(std::shared_ptr<std::atomic<int>> taken, int most, const std::string& code)
    : taken_(std::move(taken)) {
    if (taken_->fetch_add(1) < most) return;
    --*taken_;
    throw ServiceBusy(code, "as many of these requests as may are under way");
}

void answer_json(const Json& json, httplib::Response& response) {
    response.set_content(dump_json(json) + "\n", "application/json");
}

}  // namespace probebake
