// Jobs over HTTP: submit, check, list, status, cancel.
#include <algorithm>
#include <condition_variable>
#include <thread>

#include "bake/forecast.h"
#include "bake/probe_places.h"
#include "http/api.h"
#include "http/file_answer.h"
#include "http/page_token.h"
#include "http/query.h"
#include "io/io_error.h"
#include "io/sha256.h"

namespace probebake {
namespace {

constexpr const char* kRetrySeconds = "1";
constexpr uint64_t kMaxPage = 100;
constexpr uint64_t kDefaultPage = 20;
/// Of a request within the body limit; depth as io/json.h has it.
constexpr JsonLimits kRequestLimits{.max_values = 100'000};

/// Cancels a token when a time is over.
class Deadline {
  public:
    explicit Deadline(std::chrono::milliseconds time)
        : timer_([this, time](const std::stop_token& stop) {
              std::unique_lock lock(mutex_);
              ended_.wait_for(lock, stop, time, [] { return false; });
              if (!stop.stop_requested()) token_.cancel();
          }) {}
    const CancelToken& token() const { return token_; }

  private:
    CancelToken token_;
    std::mutex mutex_;
    std::condition_variable_any ended_;
    std::jthread timer_;
};

std::optional<std::string> key_of(const httplib::Request& request) {
    if (!request.has_header("Idempotency-Key")) return std::nullopt;
    const std::string key = request.get_header_value("Idempotency-Key");
    constexpr size_t kMaxBytes = 255;
    const bool plain =
        std::all_of(key.begin(), key.end(), [](char c) { return c > ' ' && c < 0x7f; });
    if (key.empty() || key.size() > kMaxBytes || !plain) {
        throw ProblemError(
            {.status = 400,
             .code = "malformed",
             .detail = "expected an Idempotency-Key of 1 to 255 visible characters"});
    }
    return key;
}

void refuse_body(const httplib::Request& request) {
    if (!request.body.empty()) {
        throw SpecError(SpecError::Kind::kMalformed, "", "expected no body");
    }
}

std::string names_text(const SceneLibrary& scenes) {
    std::string text;
    for (const std::string& name : scenes.names()) text += (text.empty() ? "" : ", ") + name;
    return text;
}

}  // namespace

JobRequest Api::read_request(const Call& call) const {
    const std::string& body = call.request.body;
    return {.spec = read_job(parse_json(body, kRequestLimits)),
            .scene = {},
            .tenant = call.who.tenant,
            .idempotency_key = key_of(call.request),
            .sha256 = sha256_hex(std::as_bytes(std::span(body)))};
}

SceneFile Api::find_scene(const JobSpec& spec) const {
    std::optional<SceneFile> scene;
    try {
        scene = parts_.scenes.find(spec.scene);
    } catch (const std::exception& error) {  // the file is the service's, not the client's
        throw SpecError(SpecError::Kind::kUnacceptable, "/scene",
                        std::string("the service's scene file is broken: ") + error.what());
    }
    if (!scene) {
        throw ProblemError(
            {.status = 404,
             .code = "unknown-scene",
             .detail = "there is no scene \"" + spec.scene + "\"",
             .errors = {{"/scene", "expected one of: " + names_text(parts_.scenes)}}});
    }
    return std::move(*scene);
}

JobSnapshot Api::find_job(const Call& call) const {
    std::optional<JobSnapshot> job = parts_.jobs.find(call.params.at("id"));
    if (!job) {
        const auto tenant = parts_.store.tenant_of_expired(call.params.at("id"));
        if (tenant && call.who.sees(*tenant)) {
            throw ProblemError({.status = 410,
                                .code = "expired",
                                .detail = "the bake is gone with its files; finished ones are kept "
                                          "for a while only, see /v1/limits"});
        }
    }
    if (!job || !call.who.sees(job->tenant)) {
        throw ProblemError(
            {.status = 404, .code = "unknown-bake", .detail = "there is no bake of that id"});
    }
    return std::move(*job);
}

std::string Api::etag_of(const JobSnapshot& job) const {
    return "W/\"" + boot_id_ + "." + std::to_string(job.version) + "\"";
}

bool Api::wait_for(JobSnapshot& job, std::chrono::seconds time, bool until_ended) {
    const Place place(waiting_, parts_.max_waiting, "too-many-waiting");
    const auto end = std::chrono::steady_clock::now() + time;
    const uint64_t version = job.version;
    while (!is_terminal(job.state) && !parts_.jobs.draining() &&
           (until_ended || job.version == version)) {
        const auto left =
            std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
        if (left.count() <= 0) break;
        const auto now = parts_.jobs.wait_for_change(job.id, job.version, left);
        if (!now) return false;
        job = *now;
    }
    return true;
}

void Api::submit(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    JobRequest request = read_request(call);
    // A job that was accepted is told again, also where its scene is gone by now.
    std::optional<JobManager::Submitted> submitted = parts_.jobs.replay(request);
    if (!submitted) {
        request.scene = find_scene(request.spec);
        submitted = parts_.jobs.submit(request);
    }
    JobSnapshot& job = submitted->job;
    call.response.status = 202;
    if (const auto time = read_wait(call.request); time && !submitted->replayed) {
        try {
            // Where retention has removed it meanwhile, this tells what was seen of it last.
            wait_for(job, *time, true);
            if (is_terminal(job.state)) call.response.status = 201;
        } catch (const ServiceBusy&) {  // the job is taken: the client may ask for it later
        }
    }
    call.response.set_header("Location", "/v1/bakes/" + job.id);
    if (submitted->replayed) call.response.set_header("Idempotency-Replayed", "true");
    if (!is_terminal(job.state)) call.response.set_header("Retry-After", kRetrySeconds);
    answer_json(write_job_status(job), call.response);
}

void Api::check(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    JobRequest request = read_request(call);
    request.scene = find_scene(request.spec);
    const Place place(checks_, parts_.max_checks, "too-many-checks");
    const Deadline deadline(parts_.check_time);
    std::shared_ptr<const Scene> scene;
    try {
        scene = parts_.load(request.scene, deadline.token());
    } catch (const Cancelled&) {
        throw ServiceBusy("scene-loading", "the scene is still being loaded");
    } catch (const IoError& error) {
        throw SpecError(SpecError::Kind::kUnacceptable, "/scene",
                        std::string("the scene cannot be loaded: ") + error.what());
    }
    JobSpec spec = request.spec;
    std::optional<PlacesRecord> places;
    try {
        parts_.on_pool([&] { places = place_probes(*scene, spec, deadline.token()); });
    } catch (const Cancelled&) {
        spec = request.spec;  // planned where they were asked for
    }
    const Plan plan = make_plan(*scene, spec);
    Json answer = {{"valid", true},
                   {"effective_request", write_job(spec)},
                   {"plan", write_plan(plan)},
                   {"validity", places ? write_places(spec, *places) : Json()}};
    try {
        parts_.on_pool([&] {
            const SkySource skies = [&](const std::filesystem::path& picture) {
                return parts_.sky(picture, deadline.token());
            };
            answer["estimate"] = write_forecast(
                make_forecast(*scene, spec, plan, parts_.threads, deadline.token(), skies));
        });
    } catch (const Cancelled&) {
        answer["estimate"] = nullptr;  // the renderers are busy, or the job's probes take too long
    }
    answer_json(answer, call.response);
}

void Api::list(const Call& call) {
    QueryReader query(call.request);
    JobQuery wanted;
    // One more than the page, to know whether another follows.
    const uint64_t page = query.integer("page_size", 1, kMaxPage, kDefaultPage);
    wanted.count = page + 1;
    if (const auto state = query.text("state")) {
        wanted.state = job_state_of(*state);
        if (!wanted.state) {
            QueryReader::refuse("state",
                                "expected QUEUED, RUNNING, CANCELLING, SUCCEEDED, FAILED or "
                                "CANCELLED");
        }
    }
    if (const auto token = query.text("page_token")) {
        wanted.before = read_bake_token(*token);
        if (!wanted.before) QueryReader::refuse("page_token", "expected what a page before gave");
    }
    query.refuse_unknown();
    if (!call.who.is_admin()) wanted.tenant = call.who.tenant;

    std::vector<JobSnapshot> jobs = parts_.jobs.list(wanted);
    Json json = {{"bakes", Json::array()}};
    if (jobs.size() > page) {
        jobs.pop_back();
        json["next_page_token"] = std::to_string(jobs.back().sequence);
    }
    for (const JobSnapshot& job : jobs) json["bakes"].push_back(write_job_status(job));
    answer_json(json, call.response);
}

void Api::status(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    JobSnapshot job = find_job(call);
    const bool known = none_match_fails(call.request, etag_of(job));
    if (const auto time = read_wait(call.request); time && known && !is_terminal(job.state)) {
        if (!wait_for(job, *time, false)) job = find_job(call);  // 404, 410
    }
    const std::string etag = etag_of(job);
    call.response.set_header("ETag", etag);
    if (!is_terminal(job.state)) call.response.set_header("Retry-After", kRetrySeconds);
    if (none_match_fails(call.request, etag)) {
        call.response.status = 304;
        return;
    }
    answer_json(write_job_status(job), call.response);
}

void Api::cancel(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    refuse_body(call.request);
    find_job(call);
    const std::optional<JobSnapshot> job = parts_.jobs.cancel(call.params.at("id"));
    call.response.status = job && is_terminal(job->state) ? 200 : 202;
    answer_json(write_job_status(job ? *job : find_job(call)), call.response);
}

/// ?dry_run=true
bool dry_run_of(const httplib::Request& request) {
    QueryReader query(request);
    const std::string text = query.text("dry_run").value_or("false");
    if (text != "true" && text != "false") QueryReader::refuse("dry_run", "expected true or false");
    query.refuse_unknown();
    return text == "true";
}

void Api::remove(const Call& call) {
    const bool dry_run = dry_run_of(call.request);
    refuse_body(call.request);
    const JobSnapshot job = find_job(call);
    if (!is_terminal(job.state)) {
        throw ProblemError(
            {.status = 409,
             .code = "not-finished",
             .detail = "the bake is " + std::string(name_of(job.state)) + ": cancel it first"});
    }
    if (!dry_run) parts_.jobs.remove(job.id);
    call.response.status = 204;
}

void Api::expire(const Call& call) {
    const bool dry_run = dry_run_of(call.request);
    refuse_body(call.request);
    const Expired expired = parts_.jobs.expire(!dry_run);
    answer_json({{"dry_run", dry_run}, {"bakes", expired.jobs}, {"bytes", expired.bytes}},
                call.response);
}

Json write_job_status(const JobSnapshot& job) {
    const BakeProgress& progress = job.progress;
    Json json = {{"id", job.id},
                 {"state", name_of(job.state)},
                 {"scene", job.scene},
                 {"created_at", rfc3339(job.created)},
                 {"progress",
                  {{"units_done", progress.units_done},
                   {"units", progress.units},
                   {"seconds", progress.seconds}}},
                 {"warnings", job.warnings}};
    if (job.started) {
        json["started_at"] = rfc3339(*job.started);
        json["progress"]["phase"] = name_of(progress.phase);
    }
    if (progress.seconds_left) {
        const Interval& interval = progress.seconds_left_interval;
        json["progress"]["seconds_left"] = *progress.seconds_left;
        json["progress"]["seconds_left_interval"] = {interval.low, interval.high};
    }
    if (job.ended) json["ended_at"] = rfc3339(*job.ended);
    if (job.failure) {
        Json& error = json["error"];
        error = {{"type", "urn:probebake:" + job.failure->code}, {"detail", job.failure->detail}};
        for (const SpecIssue& issue : job.failure->issues) {
            error["errors"].push_back({{"pointer", issue.pointer}, {"detail", issue.detail}});
        }
    }
    return json;
}

}  // namespace probebake
