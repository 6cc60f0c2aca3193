// read_scene_file on anything: a scene file within its limits, or a SpecError or IoError.
#include <cmath>
#include <cstdlib>
#include <string>

#include "fuzz/memory_folder.h"
#include "io/file.h"
#include "io/spec_error.h"
#include "scene/scene_library.h"

namespace {

using namespace probebake;
namespace fs = std::filesystem;

void require(bool holds) {
    if (!holds) std::abort();
}

fs::path file() {
    static const MemoryFolder folder;
    return folder.path / "scene.json";
}

/// A file of the scene's own folder, or of one below it.
void require_inner(const fs::path& path) {
    const fs::path inner = path.lexically_relative(file().parent_path());
    require(!inner.empty() && inner.is_relative());
    for (const fs::path& part : inner) require(is_file_name(part.string()));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    write_file_atomically(file(), std::as_bytes(std::span(data, size)));
    try {
        const SceneFile scene = read_scene_file(file());
        const int sources = (scene.generator ? 1 : 0) + (scene.vox ? 1 : 0) +
                            (scene.heightmap ? 1 : 0) + (scene.mesh ? 1 : 0);
        require(sources == 1);
        require(std::isfinite(scene.voxel_size_m) && scene.voxel_size_m > 0.0);
        for (int axis = 0; axis < 3; ++axis) require(std::abs(scene.origin_m[axis]) <= 1e6);
        if (scene.vox) require_inner(*scene.vox);
        if (scene.heightmap) {
            require_inner(scene.heightmap->heights);
            if (scene.heightmap->colors) require_inner(*scene.heightmap->colors);
        }
        for (const MediumFile& medium : scene.media) {
            require(!(medium.vdb && medium.cumulus));
            if (medium.vdb) require_inner(medium.vdb->path);
        }
        require(scene.text.size() == size);
    } catch (const SpecError& error) {
        require(!error.issues().empty());
    } catch (const IoError&) {
    }
    return 0;
}
