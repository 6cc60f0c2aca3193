#include "http/metrics.h"

#include <prometheus/text_serializer.h>

#include <array>
#include <cmath>

namespace probebake {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;

const prometheus::Histogram::BucketBoundaries kRequestSeconds = {
    0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 5.0, 30.0};
const prometheus::Histogram::BucketBoundaries kJobSeconds = {0.1,  0.5,   1.0,    5.0,    10.0,
                                                             60.0, 300.0, 1800.0, 7200.0, 86400.0};

/// The methods that we know: a client must not make labels.
std::string method_label(const std::string& method) {
    constexpr std::array<std::string_view, 7> kKnown = {"GET",    "HEAD",  "POST",   "PUT",
                                                        "DELETE", "PATCH", "OPTIONS"};
    for (const std::string_view known : kKnown) {
        if (method == known) return method;
    }
    return "other";
}

const prometheus::Histogram::BucketBoundaries kErrorOverTarget = {0.1, 0.25, 0.5,  0.75, 0.9,
                                                                  1.0, 1.1,  1.25, 1.5,  2.0};

/// How large an error is, in units of its target.
double error_over_target(const std::string& metric, double error, double target) {
    if (metric == "psnr_db") return std::pow(10.0, (target - error) / 20.0);
    if (metric == "ssim") return (1.0 - error) / (1.0 - target);
    return error / target;
}

double seconds(UnixMs from, UnixMs to) {
    return std::max(0.0, static_cast<double>(to - from) / 1000.0);
}

void raise_to(prometheus::Counter& counter, double value) {
    if (value > counter.Value()) counter.Increment(value - counter.Value());
}

}  // namespace

Metrics::Metrics()
    : requests_(BuildCounter()
                    .Name("probebake_http_requests_total")
                    .Help("Requests by method and status")
                    .Register(registry_)),
      request_seconds_(BuildHistogram()
                           .Name("probebake_http_request_seconds")
                           .Help("From accepting a connection to the end of its answer")
                           .Register(registry_)
                           .Add({}, kRequestSeconds)),
      ended_(BuildCounter()
                 .Name("probebake_jobs_ended_total")
                 .Help("Jobs by the state in which they ended")
                 .Register(registry_)),
      queue_seconds_(BuildHistogram()
                         .Name("probebake_job_queue_seconds")
                         .Help("From acceptance to start")
                         .Register(registry_)
                         .Add({}, kJobSeconds)),
      bake_seconds_(BuildHistogram()
                        .Name("probebake_job_seconds")
                        .Help("From start to end")
                        .Register(registry_)
                        .Add({}, kJobSeconds)),
      units_(BuildCounter()
                 .Name("probebake_units_total")
                 .Help("Probes times lighting states of jobs that ended")
                 .Register(registry_)
                 .Add({})),
      rays_(BuildCounter()
                .Name("probebake_rays_total")
                .Help("Rays of bakes that succeeded, those of pilots and audits too")
                .Register(registry_)
                .Add({})),
      steps_(BuildCounter()
                 .Name("probebake_octree_steps_total")
                 .Help("Octree nodes that these rays entered")
                 .Register(registry_)
                 .Add({})),
      lookups_(BuildCounter()
                   .Name("probebake_media_lookups_total")
                   .Help("Look-ups of coefficients of media")
                   .Register(registry_)
                   .Add({})),
      collisions_(BuildCounter()
                      .Name("probebake_media_collisions_total")
                      .Help("Collisions of paths with media, by kind")
                      .Register(registry_)),
      faults_(BuildCounter()
                  .Name("probebake_path_faults_total")
                  .Help("Paths through media that were given up, or met more than their bound")
                  .Register(registry_)
                  .Add({})),
      error_over_target_(BuildHistogram()
                             .Name("probebake_error_over_target")
                             .Help("Error of a lighting state over its target, by metric; at most "
                                   "1 where it was met (psnr_db: ratio of RMSE, ssim: of 1 - SSIM)")
                             .Register(registry_)),
      bytes_(BuildCounter()
                 .Name("probebake_artifact_bytes_total")
                 .Help("Bytes of files of bakes that succeeded")
                 .Register(registry_)
                 .Add({})),
      mended_(BuildCounter()
                  .Name("probebake_damaged_units_total")
                  .Help("Attempts to bake units again whose files were found damaged, by what came "
                        "of them")
                  .Register(registry_)),
      recovered_(BuildCounter()
                     .Name("probebake_recovered_units_total")
                     .Help("Units that were under way when the process before this one ended")
                     .Register(registry_)
                     .Add({})),
      poisoned_(BuildCounter()
                    .Name("probebake_poisoned_units_total")
                    .Help("Of these, those that are given up")
                    .Register(registry_)
                    .Add({})),
      jobs_(BuildGauge()
                .Name("probebake_jobs")
                .Help("Jobs that are known, by state")
                .Register(registry_)),
      commits_(BuildCounter()
                   .Name("probebake_store_commits_total")
                   .Help("Transactions on the disk")
                   .Register(registry_)
                   .Add({})),
      writes_(BuildCounter()
                  .Name("probebake_store_writes_total")
                  .Help("Writes in these transactions")
                  .Register(registry_)
                  .Add({})),
      commit_seconds_(BuildCounter()
                          .Name("probebake_store_commit_seconds_total")
                          .Help("Time that transactions took")
                          .Register(registry_)
                          .Add({})),
      disk_free_(BuildGauge()
                     .Name("probebake_disk_free_bytes")
                     .Help("Room on the disk of the data directory")
                     .Register(registry_)
                     .Add({})),
      promised_(BuildGauge()
                    .Name("probebake_promised_bytes")
                    .Help("That jobs which wait or run may still write")
                    .Register(registry_)
                    .Add({})) {
    // There from the start, so that the first one is an increase.
    for (const char* kind : {"real", "null"}) collisions_.Add({{"kind", kind}});
    for (const char* result : {"mended", "not_mended"}) mended_.Add({{"result", result}});
    for (const JobState state : {JobState::kSucceeded, JobState::kFailed, JobState::kCancelled}) {
        ended_.Add({{"state", std::string(name_of(state))}});
    }
}

void Metrics::count_request(const RequestLog& request) {
    requests_
        .Add({{"method", method_label(request.method)}, {"status", std::to_string(request.status)}})
        .Increment();
    request_seconds_.Observe(request.seconds);
}

void Metrics::count_job(const JobSnapshot& job) {
    if (job.state == JobState::kRunning && job.started) {
        queue_seconds_.Observe(seconds(job.created, *job.started));
    }
    if (!is_terminal(job.state)) return;
    ended_.Add({{"state", std::string(name_of(job.state))}}).Increment();
    units_.Increment(static_cast<double>(job.progress.units_done));
    if (job.started && job.ended) bake_seconds_.Observe(seconds(*job.started, *job.ended));
}

void Metrics::count_report(const Json& report) {
    const Json& totals = report.at("totals");
    bytes_.Increment(totals.at("bytes").get<double>());
    for (const auto& [part, cost] : totals.at("cost").items()) {
        if (!cost.is_object()) continue;
        rays_.Increment(cost.value("rays", 0.0) + cost.value("discarded_rays", 0.0));
        steps_.Increment(cost.value("steps", 0.0));
        const auto media = cost.find("media");
        if (media == cost.end()) continue;
        lookups_.Increment(media->value("lookups", 0.0));
        collisions_.Add({{"kind", "real"}}).Increment(media->value("collisions", 0.0));
        collisions_.Add({{"kind", "null"}}).Increment(media->value("null_collisions", 0.0));
        faults_.Increment(media->value("faults", 0.0));
    }
    const Json& targets = report.at("effective_request").at("quality").at("targets");
    for (const Json& state : report.at("states")) {
        const auto error = state.find("error");
        if (error == state.end() || !error->is_object()) continue;
        for (const auto& [metric, target] : targets.items()) {
            const auto found = error->find(metric);
            if (found == error->end() || !found->is_number()) continue;
            const double ratio = error_over_target(metric, found->get<double>(), target);
            if (std::isfinite(ratio)) {
                error_over_target_.Add({{"metric", metric}}, kErrorOverTarget).Observe(ratio);
            }
        }
    }
}

void Metrics::count_mended(size_t units, bool mended) {
    mended_.Add({{"result", mended ? "mended" : "not_mended"}})
        .Increment(static_cast<double>(units));
}

std::string Metrics::scrape(const JobManager& jobs, const JobStore& store) {
    const std::lock_guard lock(scraping_);
    const std::map<JobState, size_t> counts = jobs.counts();
    for (int i = 0; i <= static_cast<int>(JobState::kCancelled); ++i) {
        const auto state = static_cast<JobState>(i);
        const auto at = counts.find(state);
        jobs_.Add({{"state", std::string(name_of(state))}})
            .Set(at == counts.end() ? 0.0 : static_cast<double>(at->second));
    }
    const JobStore::Counts store_counts = store.counts();
    raise_to(commits_, static_cast<double>(store_counts.commits));
    raise_to(writes_, static_cast<double>(store_counts.writes));
    raise_to(commit_seconds_, store_counts.commit_seconds);
    raise_to(recovered_, static_cast<double>(store.recovered().units));
    raise_to(poisoned_, static_cast<double>(store.recovered().poison));
    disk_free_.Set(static_cast<double>(store.data().free_bytes()));
    promised_.Set(static_cast<double>(jobs.promised_bytes()));
    return prometheus::TextSerializer().Serialize(registry_.Collect());
}

}  // namespace probebake
