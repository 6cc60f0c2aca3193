// The service's data directory: made at start, locked for as long as the service runs.
//
//   DIR/lock         held with flock, so that two services never share a directory
//   DIR/jobs/{id}/   one folder per job
//
// Jobs live in memory: the folders of an earlier run belong to no job any more and are removed at
// start. Only folders directly below DIR/jobs whose names are job ids are touched.
#pragma once

#include <filesystem>

#include "jobs/open_file.h"

namespace probebake {

class DataFolder {
  public:
    /// Throws IoError, in one line, where the directory cannot be made, written or locked.
    explicit DataFolder(const std::filesystem::path& folder);

    std::filesystem::path jobs() const { return folder_ / "jobs"; }

  private:
    std::filesystem::path folder_;
    Descriptor lock_;
};

}  // namespace probebake
