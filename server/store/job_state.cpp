#include "store/job_state.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace probebake {
namespace {

constexpr std::array<std::string_view, 6> kStateNames = {"QUEUED",    "RUNNING", "CANCELLING",
                                                         "SUCCEEDED", "FAILED",  "CANCELLED"};
constexpr std::string_view kIdPrefix = "b-";
constexpr size_t kIdBytes = 16;

}  // namespace

std::string_view name_of(JobState state) { return kStateNames[static_cast<size_t>(state)]; }

std::optional<JobState> job_state_of(std::string_view name) {
    const auto at = std::find(kStateNames.begin(), kStateNames.end(), name);
    if (at == kStateNames.end()) return std::nullopt;
    return static_cast<JobState>(at - kStateNames.begin());
}

std::string new_job_id() {
    std::array<unsigned char, kIdBytes> bytes{};
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
        throw std::runtime_error(std::string("getrandom: ") + std::strerror(errno));
    }
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string id(kIdPrefix);
    for (const unsigned char byte : bytes) {
        id += kDigits[byte >> 4];
        id += kDigits[byte & 15];
    }
    return id;
}

bool is_job_id(std::string_view text) {
    return text.size() == kIdPrefix.size() + 2 * kIdBytes && text.substr(0, 2) == kIdPrefix &&
           std::all_of(text.begin() + 2, text.end(),
                       [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

}  // namespace probebake
