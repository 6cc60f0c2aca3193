// unpack_scene on anything: plain files beneath its folder that take no more than the archive, or
// an IoError.
#include <cstdlib>
#include <string>

#include "engine/scene_archive.h"
#include "fuzz/memory_folder.h"
#include "io/file.h"
#include "io/io_error.h"
#include "scene/scene_library.h"

namespace {

using namespace probebake;
namespace fs = std::filesystem;

void require(bool holds) {
    if (!holds) std::abort();
}

const fs::path& folder() {
    static const MemoryFolder folder;
    return folder.path;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const fs::path inside = folder() / "inside";
    const fs::path archive = folder() / "archive";
    fs::remove_all(folder());
    fs::create_directories(inside);
    write_file_atomically(archive, std::as_bytes(std::span(data, size)));
    bool taken = false;
    try {
        unpack_scene(archive, inside, "castle");
        taken = true;
    } catch (const IoError&) {
    }
    uint64_t bytes = 0;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(inside)) {
        const fs::file_status status = entry.symlink_status();
        require(fs::is_regular_file(status) || fs::is_directory(status));
        require(is_file_name(entry.path().filename().string()));
        if (fs::is_regular_file(status)) bytes += entry.file_size();
    }
    require(bytes <= size);
    require(!taken || fs::is_regular_file(inside / "castle.json"));
    size_t outside = 0;
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder())) ++outside;
    require(outside == 2);
    return 0;
}
