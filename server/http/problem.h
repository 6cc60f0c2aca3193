// Errors as RFC 9457 problem details: what every refusal of the service looks like.
//
//   {"type": "urn:probebake:queue-full", "title": "Service Unavailable", "status": 503,
//    "detail": "...", "errors": [{"pointer": "/probes/list/0/id", "detail": "..."}],
//    "request_id": "r-..."}
//
// `errors` is there where several things can be wrong; a pointer is a JSON pointer into the
// request's body, or "?name" for a parameter of the query. docs/service.md lists the types.
#pragma once

#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/json.h"
#include "io/spec_error.h"

namespace probebake {

inline constexpr const char* kProblemType = "application/problem+json";

struct Problem {
    int status = 500;
    std::string code;  // the last part of the type
    std::string detail;
    std::vector<SpecIssue> errors = {};
    std::optional<int> retry_after_seconds = {};
    std::string allow = {};     // methods, for 405
    bool authenticate = false;  // for 401
};

/// Ends a request.
class ProblemError : public std::exception {
  public:
    explicit ProblemError(Problem problem) : problem_(std::move(problem)) {}
    const Problem& problem() const { return problem_; }
    const char* what() const noexcept override { return problem_.detail.c_str(); }

  private:
    Problem problem_;
};

/// The standard phrase of a status code.
std::string_view phrase_of(int status);

/// What a client is told of an exception. The text of anything unexpected stays out of it.
Problem problem_of(const std::exception_ptr& exception);

Json write_problem(const Problem& problem, const std::string& request_id);

/// A whole response, for requests that the HTTP library is not shown.
std::string raw_response(const Problem& problem, const std::string& request_id);

}  // namespace probebake
