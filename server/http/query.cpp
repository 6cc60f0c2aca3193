#include "http/query.h"

#include <algorithm>
#include <charconv>

namespace probebake {

std::optional<uint64_t> read_digits(std::string_view text) {
    uint64_t value = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    if (text.empty() || error != std::errc() || rest != end) return std::nullopt;
    return value;
}

std::optional<std::chrono::seconds> read_wait(const httplib::Request& request) {
    constexpr uint64_t kMaxSeconds = 30;
    constexpr std::string_view kWait = "wait=";
    const std::string text = request.get_header_value("Prefer");
    for (size_t at = 0; at < text.size();) {  // "respond-async, wait=10"
        const size_t end = std::min(text.find(',', at), text.size());
        std::string_view preference = std::string_view(text).substr(at, end - at);
        while (preference.starts_with(' ')) preference.remove_prefix(1);
        while (preference.ends_with(' ')) preference.remove_suffix(1);
        at = end + 1;
        if (!preference.starts_with(kWait)) continue;
        const std::optional<uint64_t> seconds = read_digits(preference.substr(kWait.size()));
        if (seconds) return std::chrono::seconds(std::min(*seconds, kMaxSeconds));
    }
    return std::nullopt;
}

void QueryReader::refuse(const std::string& name, const std::string& detail) {
    throw SpecError(SpecError::Kind::kMalformed, "?" + name, detail);
}

std::optional<std::string> QueryReader::text(const std::string& name) {
    known_.insert(name);
    const auto [begin, end] = params_.equal_range(name);
    if (begin == end) return std::nullopt;
    if (std::next(begin) != end) refuse(name, "is repeated");
    return begin->second;
}

uint64_t QueryReader::integer(const std::string& name, uint64_t min, uint64_t max,
                              uint64_t fallback) {
    const std::optional<std::string> given = text(name);
    if (!given) return fallback;
    const std::optional<uint64_t> value = read_digits(*given);
    if (!value || *value < min || *value > max) {
        refuse(name,
               "expected an integer from " + std::to_string(min) + " to " + std::to_string(max));
    }
    return *value;
}

void QueryReader::refuse_unknown() const {
    for (const auto& [name, value] : params_) {
        if (known_.contains(name)) continue;
        std::string expected;
        for (const std::string& known : known_) expected += (expected.empty() ? "" : ", ") + known;
        refuse(name, expected.empty() ? "is unknown, expected no parameters"
                                      : "is unknown, expected only: " + expected);
    }
}

}  // namespace probebake
