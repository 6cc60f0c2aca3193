#include "jobs/job.h"

#include <array>
#include <cstdio>
#include <ctime>
#include <variant>

#include "io/file_beneath.h"
#include "io/sha256.h"

namespace probebake {

std::string rfc3339(UnixMs time) {
    const std::chrono::milliseconds milliseconds(time);
    const auto whole = std::chrono::floor<std::chrono::seconds>(milliseconds);
    const std::time_t seconds = whole.count();
    std::tm utc{};
    ::gmtime_r(&seconds, &utc);
    std::array<char, 32> date{};
    std::strftime(date.data(), date.size(), "%Y-%m-%dT%H:%M:%S", &utc);
    std::array<char, 8> fraction{};
    std::snprintf(fraction.data(), fraction.size(), ".%03dZ",
                  static_cast<int>((milliseconds - whole).count()));
    return std::string(date.data()) + fraction.data();
}

std::string pinned_sha256(const SceneFile& scene, const JobSpec& spec) {
    std::string digests = content_sha256(scene);
    for (const LightingState& state : spec.states) {
        const auto* const picture =
            state.sky ? std::get_if<SkyFileSpec>(&state.sky->what) : nullptr;
        if (picture == nullptr) continue;
        constexpr uint64_t kMaxBytes = uint64_t{1} << 30;
        try {
            digests += sha256_hex(read_file_beneath(scene.folder / picture->file, kMaxBytes));
        } catch (const IoError&) {  // the plan refuses it, with a pointer to it
            digests += "unreadable";
        }
    }
    return sha256_hex(std::as_bytes(std::span(digests)));
}

Json write_failure(const JobFailure& failure) {
    Json json = {{"code", failure.code}, {"detail", failure.detail}};
    for (const SpecIssue& issue : failure.issues) {
        json["errors"].push_back({{"pointer", issue.pointer}, {"detail", issue.detail}});
    }
    return json;
}

JobFailure read_failure(const Json& json) {
    JobFailure failure{json.at("code"), json.at("detail"), {}};
    for (const Json& issue : json.value("errors", Json::array())) {
        failure.issues.push_back({issue.at("pointer"), issue.at("detail")});
    }
    return failure;
}

}  // namespace probebake
