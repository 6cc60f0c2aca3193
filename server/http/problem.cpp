#include "http/problem.h"

#include "jobs/job_manager.h"

namespace probebake {

std::string_view phrase_of(int status) {
    switch (status) {
        case 400:
            return "Bad Request";
        case 401:
            return "Unauthorized";
        case 403:
            return "Forbidden";
        case 404:
            return "Not Found";
        case 405:
            return "Method Not Allowed";
        case 408:
            return "Request Timeout";
        case 409:
            return "Conflict";
        case 411:
            return "Length Required";
        case 413:
            return "Content Too Large";
        case 414:
            return "URI Too Long";
        case 415:
            return "Unsupported Media Type";
        case 416:
            return "Range Not Satisfiable";
        case 417:
            return "Expectation Failed";
        case 421:
            return "Misdirected Request";
        case 422:
            return "Unprocessable Content";
        case 410:
            return "Gone";
        case 429:
            return "Too Many Requests";
        case 431:
            return "Request Header Fields Too Large";
        case 500:
            return "Internal Server Error";
        case 501:
            return "Not Implemented";
        case 503:
            return "Service Unavailable";
        default:
            return "Error";
    }
}

Problem problem_of(const std::exception_ptr& exception) {
    try {
        std::rethrow_exception(exception);
    } catch (const ProblemError& error) {
        return error.problem();
    } catch (const SpecError& error) {
        const bool malformed = error.kind() == SpecError::Kind::kMalformed;
        return {.status = malformed ? 400 : 422,
                .code = malformed ? "malformed" : "unacceptable",
                .detail = malformed ? "the request is not well-formed"
                                    : "the request asks for what cannot be done",
                .errors = error.issues()};
    } catch (const ServiceBusy& error) {
        return {.status = error.code() == "quota" ? 429 : 503,
                .code = error.code(),
                .detail = error.what(),
                .retry_after_seconds = 5};
    } catch (const DiskFull&) {
        return {.status = 503,
                .code = "disk-full",
                .detail = "the disk is full",
                .retry_after_seconds = 60};
    } catch (const JobExpired&) {
        return {.status = 410,
                .code = "expired",
                .detail = "the bake of that Idempotency-Key is gone with its files"};
    } catch (const KeyReused&) {
        return {.status = 422,
                .code = "key-reused",
                .detail = "that Idempotency-Key came with another request before"};
    } catch (...) {
        return {.status = 500, .code = "internal", .detail = "an internal error"};
    }
}

Json write_problem(const Problem& problem, const std::string& request_id) {
    Json json = {{"type", "urn:probebake:" + problem.code},
                 {"title", phrase_of(problem.status)},
                 {"status", problem.status},
                 {"detail", problem.detail},
                 {"request_id", request_id}};
    for (const SpecIssue& issue : problem.errors) {
        json["errors"].push_back({{"pointer", issue.pointer}, {"detail", issue.detail}});
    }
    return json;
}

std::string raw_response(const Problem& problem, const std::string& request_id) {
    const std::string body = dump_json(write_problem(problem, request_id)) + "\n";
    std::string text = "HTTP/1.1 " + std::to_string(problem.status) + " " +
                       std::string(phrase_of(problem.status)) +
                       "\r\nConnection: close\r\nContent-Type: " + kProblemType +
                       "\r\nContent-Length: " + std::to_string(body.size()) +
                       "\r\nX-Request-Id: " + request_id + "\r\n";
    if (problem.retry_after_seconds) {
        text += "Retry-After: " + std::to_string(*problem.retry_after_seconds) + "\r\n";
    }
    return text + "\r\n" + body;
}

}  // namespace probebake
