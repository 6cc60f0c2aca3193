// A bake's files, fetched from a service into a folder:
//
//   OUT/{probe}/{state}/cube.exr, aux.exr   OUT/probes.jsonl   OUT/report.json
//
// as `probebake bake` would have left them. Every file is checked against the size and SHA-256 of
// its row; files that are there and match are not fetched again.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "commands/service_client.h"

namespace probebake {

struct Download {
    /// No value for a bake that was cancelled, failed, or has not ended.
    std::optional<Json> report;
    std::vector<Json> rows;  // without what they say of single faces
    uint64_t files = 0;
    uint64_t kept = 0;  // of these, files that were there already
    uint64_t bytes = 0;
};

/// `on_file` is told how many files are done. Throws ServiceError and IoError.
Download download_bake(ServiceClient& service, const std::string& id,
                       const std::filesystem::path& out,
                       const std::function<void(uint64_t)>& on_file);

}  // namespace probebake
