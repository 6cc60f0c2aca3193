#include "log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace probebake {
namespace {

spdlog::logger& logger() {
    static const std::shared_ptr<spdlog::logger> instance = [] {
        auto made = spdlog::stderr_logger_mt("probebake");
        made->set_pattern("%v");  // the line is whole as it comes
        return made;
    }();
    return *instance;
}

void write(spdlog::level::level_enum level, Json line) {
    line["time"] = rfc3339(unix_ms_now());
    line["level"] = level == spdlog::level::info   ? "info"
                    : level == spdlog::level::warn ? "warning"
                                                   : "error";
    logger().log(level, dump_json(line));
}

}  // namespace

void log_request(const RequestLog& line) {
    // Not the query: whoever writes a token there by mistake shall not find it in the log.
    const std::string path = line.target.substr(0, line.target.find('?'));
    Json json = {{"event", "request"},
                 {"request_id", line.request_id},
                 {"peer", line.peer},
                 {"method", line.method},
                 {"path", path},
                 {"status", line.status},
                 {"bytes", line.bytes_sent},
                 {"seconds", line.seconds}};
    if (!line.cause.empty()) json["cause"] = line.cause;
    const auto level = line.status >= 500 && line.status != 503 ? spdlog::level::err
                       : !line.cause.empty()                    ? spdlog::level::warn
                                                                : spdlog::level::info;
    write(level, std::move(json));
}

void log_job(const JobSnapshot& job, const std::string& cause) {
    Json json = {{"event", "job"},
                 {"id", job.id},
                 {"state", name_of(job.state)},
                 {"scene", job.scene},
                 {"units", job.progress.units}};
    if (job.failure) json["failure"] = job.failure->detail;
    if (!cause.empty()) json["cause"] = cause;
    write(job.state == JobState::kFailed ? spdlog::level::err : spdlog::level::info,
          std::move(json));
}

void log_mend(const std::string& id, size_t units, const std::string& cause) {
    Json json = {{"event", cause.empty() ? "mended" : "not-mended"}, {"id", id}, {"units", units}};
    if (!cause.empty()) json["cause"] = cause;
    write(cause.empty() ? spdlog::level::warn : spdlog::level::err, std::move(json));
}

void log_event(const std::string& event, const std::string& detail) {
    write(spdlog::level::info, {{"event", event}, {"detail", detail}});
}

void log_warning(const std::string& event, const std::string& detail) {
    write(spdlog::level::warn, {{"event", event}, {"detail", detail}});
}

}  // namespace probebake
