// What the service counts, as Prometheus reads it.
//
// Few labels, all of them ours: nothing a client writes becomes one. Units are in the names.
#pragma once

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <mutex>
#include <string>

#include "http/http_server.h"
#include "jobs/job_manager.h"

namespace probebake {

class Metrics {
  public:
    Metrics();

    void count_request(const RequestLog& request);
    /// A job entered a state.
    void count_job(const JobSnapshot& job);
    void count_report(const Json& report);
    void count_mended(size_t units, bool mended);

    /// The text of a scrape, with what jobs and store say now.
    std::string scrape(const JobManager& jobs, const JobStore& store);

  private:
    /// Held by a whole scrape: of two at once each would set a part of the other's figures, and
    /// both would add the store's same increase.
    std::mutex scraping_;
    prometheus::Registry registry_;
    prometheus::Family<prometheus::Counter>& requests_;
    prometheus::Histogram& request_seconds_;
    prometheus::Family<prometheus::Counter>& ended_;
    prometheus::Histogram& queue_seconds_;
    prometheus::Histogram& bake_seconds_;
    prometheus::Counter& units_;
    prometheus::Counter& rays_;
    prometheus::Counter& steps_;
    prometheus::Counter& lookups_;
    prometheus::Family<prometheus::Counter>& collisions_;
    prometheus::Counter& faults_;
    prometheus::Family<prometheus::Histogram>& error_over_target_;
    prometheus::Counter& bytes_;
    prometheus::Family<prometheus::Counter>& mended_;
    prometheus::Counter& recovered_;
    prometheus::Counter& poisoned_;
    prometheus::Family<prometheus::Gauge>& jobs_;
    prometheus::Counter& commits_;
    prometheus::Counter& writes_;
    prometheus::Counter& commit_seconds_;
    prometheus::Gauge& disk_free_;
    prometheus::Gauge& promised_;
};

}  // namespace probebake
