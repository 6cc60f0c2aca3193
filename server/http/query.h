// The query of a URL, read as strictly as a body: unknown and repeated parameters are refused; and
// what a client prefers, which is ignored where it is not understood.
#pragma once

#include <httplib.h>

#include <chrono>
#include <optional>
#include <set>
#include <string>

#include "io/spec_error.h"

namespace probebake {

class QueryReader {
  public:
    explicit QueryReader(const httplib::Request& request) : params_(request.params) {}

    /// No value where the parameter is absent. Throws SpecError where it is repeated.
    std::optional<std::string> text(const std::string& name);
    /// An integer from min to max, in decimal digits.
    uint64_t integer(const std::string& name, uint64_t min, uint64_t max, uint64_t fallback);
    /// The last call.
    void refuse_unknown() const;

    /// Throws SpecError about a parameter.
    [[noreturn]] static void refuse(const std::string& name, const std::string& detail);

  private:
    const httplib::Params& params_;
    std::set<std::string> known_;
};

/// Digits and nothing else, up to the largest uint64_t.
std::optional<uint64_t> read_digits(std::string_view text);

/// `Prefer: wait=N` (RFC 7240): seconds, at most 30; none where the client did not say.
std::optional<std::chrono::seconds> read_wait(const httplib::Request& request);

}  // namespace probebake
