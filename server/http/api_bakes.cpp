// Jobs over HTTP: submit, check, list, status, cancel.
#include <condition_variable>
#include <thread>

#include "bake/forecast.h"
#include "http/api.h"
#include "http/query.h"
#include "io/io_error.h"

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

/// One of a bounded number of places.
class Place {
  public:
    Place(std::atomic<int>& taken, int most) : taken_(taken) {
        if (taken_.fetch_add(1) < most) return;
        --taken_;
        throw ServiceBusy("too-many-checks", "as many checks as may are under way");
    }
    ~Place() { --taken_; }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

  private:
    std::atomic<int>& taken_;
};

std::string names_text(const SceneLibrary& scenes) {
    std::string text;
    for (const std::string& name : scenes.names()) text += (text.empty() ? "" : ", ") + name;
    return text;
}

}  // namespace

JobRequest Api::read_request(const httplib::Request& request) const {
    JobRequest out{.spec = read_job(parse_json(request.body, kRequestLimits)), .scene = {}};
    std::optional<SceneFile> scene;
    try {
        scene = parts_.scenes.find(out.spec.scene);
    } catch (const std::exception& error) {  // the file is the service's, not the client's
        throw SpecError(SpecError::Kind::kUnacceptable, "/scene",
                        std::string("the service's scene file is broken: ") + error.what());
    }
    if (!scene) {
        throw ProblemError(
            {.status = 404,
             .code = "unknown-scene",
             .detail = "there is no scene \"" + out.spec.scene + "\"",
             .errors = {{"/scene", "expected one of: " + names_text(parts_.scenes)}}});
    }
    out.scene = std::move(*scene);
    return out;
}

JobSnapshot Api::find_job(const Call& call) const {
    std::optional<JobSnapshot> job = parts_.jobs.find(call.params.at("id"));
    if (!job) {
        throw ProblemError({.status = 404,
                            .code = "unknown-bake",
                            .detail = "there is no bake of that id; finished ones are kept for a "
                                      "while only, see /v1/limits"});
    }
    return std::move(*job);
}

void Api::submit(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const JobSnapshot job = parts_.jobs.submit(read_request(call.request));
    call.response.status = 202;
    call.response.set_header("Location", "/v1/bakes/" + job.id);
    call.response.set_header("Retry-After", kRetrySeconds);
    answer_json(write_job_status(job), call.response);
}

void Api::check(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    const JobRequest request = read_request(call.request);
    const Place place(checks_, parts_.max_checks);
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
    const Plan plan = make_plan(*scene, request.spec);
    Json answer = {{"valid", true},
                   {"effective_request", write_job(request.spec)},
                   {"plan", write_plan(plan)}};
    try {
        parts_.on_pool([&] {
            answer["estimate"] = write_forecast(
                make_forecast(*scene, request.spec, plan, parts_.threads, deadline.token()));
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
        wanted.before = read_digits(*token);
        if (!wanted.before) QueryReader::refuse("page_token", "expected what a page before gave");
    }
    query.refuse_unknown();

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
    const JobSnapshot job = find_job(call);
    if (!is_terminal(job.state)) call.response.set_header("Retry-After", kRetrySeconds);
    answer_json(write_job_status(job), call.response);
}

void Api::cancel(const Call& call) {
    QueryReader(call.request).refuse_unknown();
    if (!call.request.body.empty()) {
        throw SpecError(SpecError::Kind::kMalformed, "", "expected no body");
    }
    find_job(call);
    const std::optional<JobSnapshot> job = parts_.jobs.cancel(call.params.at("id"));
    call.response.status = job && is_terminal(job->state) ? 200 : 202;
    answer_json(write_job_status(job ? *job : find_job(call)), call.response);
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
