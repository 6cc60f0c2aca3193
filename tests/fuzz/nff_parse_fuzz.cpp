// parse_nff on anything: a scene whose octree can be built and cast into, or an IoError that names
// a line of the text.
#include <algorithm>
#include <cstdlib>
#include <string>

#include "io/io_error.h"
#include "objects/object_octree.h"
#include "scene/nff/nff_file.h"

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace probebake;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const auto lines = std::count(text.begin(), text.end(), '\n') + 1;
    try {
        const NffScene scene = parse_nff(text, "fuzz.nff");
        require(scene.objects.size() == scene.shapes.size());
        for (const NffObject& object : scene.objects) {
            require(object.material < scene.materials.size());
        }
        const ObjectBoxes boxes = safe_boxes(scene.shapes);
        if (!is_finite(boxes.root.low) || !is_finite(boxes.root.high)) return 0;
        const ObjectOctree octree(scene.shapes, boxes, {.max_depth = 4});
        const Ray ray{Vec3(-10.0, 0.1, 0.2), Vec3(1.0, 0.01, 0.02)};
        require(octree.closest_hit(ray) == closest_hit_of_all(scene.shapes, boxes.root, ray));
    } catch (const IoError& error) {
        const std::string what = error.what();
        const std::string prefix = "fuzz.nff: line ";
        require(what.compare(0, prefix.size(), prefix) == 0);
        const long line = std::strtol(what.c_str() + prefix.size(), nullptr, 10);
        require(line >= 1 && line <= lines);
    }
    return 0;
}
