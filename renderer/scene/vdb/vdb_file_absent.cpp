#include "scene/vdb/vdb_file.h"

namespace probebake {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& path) {
    throw IoError(path.filename().string(), "this build reads no OpenVDB files");
}

}  // namespace

bool reads_vdb() { return false; }

VdbGrid read_vdb_grid(const std::filesystem::path& path, const std::string& /*grid_name*/) {
    refuse(path);
}

std::vector<std::string> vdb_grid_names(const std::filesystem::path& path) { refuse(path); }

}  // namespace probebake
