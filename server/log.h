// The service's log: one line of JSON per event on the standard error output.
//
// Whatever a client wrote stands in it as a JSON string: it can neither end a line nor forge one.
#pragma once

#include <string>

#include "http/http_server.h"
#include "jobs/job.h"

namespace probebake {

void log_request(const RequestLog& line);
void log_job(const JobSnapshot& job, const std::string& cause);
/// Damaged files of a job were baked again; where they could not be, why.
void log_mend(const std::string& id, size_t units, const std::string& cause);
void log_event(const std::string& event, const std::string& detail);
void log_warning(const std::string& event, const std::string& detail);

}  // namespace probebake
