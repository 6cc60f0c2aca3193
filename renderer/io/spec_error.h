// What is wrong with something a client wrote: where it stands, what was expected.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace probebake {

struct SpecIssue {
    std::string pointer;  // JSON pointer (RFC 6901) to the value; "" is the whole document
    std::string detail;   // what was wrong and what was expected

    bool operator==(const SpecIssue&) const = default;
};

/// Ends a request. Malformed documents (syntax, unknown fields, wrong types) are the client's
/// program's fault, HTTP 400; well-formed ones that ask for what cannot be, 422.
class SpecError : public std::runtime_error {
  public:
    enum class Kind { kMalformed, kUnacceptable };

    SpecError(Kind kind, std::vector<SpecIssue> issues)
        : std::runtime_error(describe(issues)), kind_(kind), issues_(std::move(issues)) {}
    SpecError(Kind kind, std::string pointer, std::string detail)
        : SpecError(kind, {{std::move(pointer), std::move(detail)}}) {}

    Kind kind() const { return kind_; }
    const std::vector<SpecIssue>& issues() const { return issues_; }

  private:
    static std::string describe(const std::vector<SpecIssue>& issues) {
        std::string text;
        for (const SpecIssue& issue : issues) {
            if (!text.empty()) text += "\n";
            text += (issue.pointer.empty() ? "(document)" : issue.pointer) + ": " + issue.detail;
        }
        return text;
    }

    Kind kind_;
    std::vector<SpecIssue> issues_;
};

}  // namespace probebake
