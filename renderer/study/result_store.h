// Finished results of a study, one file each, so that a second run does not compute them again.
//
// A file holds what its result depends on (the key: experiment, parameters, hash of the scene) and
// the result; one with another key, or damaged, counts as none. Written atomically.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "io/json.h"

namespace probebake::study {

class ResultStore {
  public:
    /// Creates the folder. Throws IoError where that fails.
    explicit ResultStore(std::filesystem::path folder);

    std::optional<Json> find(const std::string& name, const Json& key) const;
    void put(const std::string& name, const Json& key, const Json& result) const;

  private:
    std::filesystem::path path_of(const std::string& name) const;

    std::filesystem::path folder_;
};

}  // namespace probebake::study
