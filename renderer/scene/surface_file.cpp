#include "scene/surface_file.h"

#include "io/checked_file.h"

namespace probebake {
namespace {

constexpr std::string_view kKind = "surface";
constexpr uint64_t kVersion = 1;

}  // namespace

void save_surface(const std::filesystem::path& path, const SurfaceTriangles& surface) {
    const std::array sections = {std::as_bytes(std::span(&surface.one_sided, 1)),
                                 std::as_bytes(std::span(surface.triangles))};
    write_checked_file(path, kKind, kVersion, sections);
}

SurfaceTriangles load_surface(const std::filesystem::path& path) {
    const CheckedFile file(path, kKind, kVersion);
    const std::vector<uint64_t> one_sided = file.array<uint64_t>(0);
    SurfaceTriangles surface{.triangles = file.array<std::array<IVec3, 3>>(1)};
    if (one_sided.size() != 1 || one_sided[0] > surface.triangles.size()) {
        throw IoError(file.name(), "has more one-sided triangles than triangles");
    }
    surface.one_sided = one_sided[0];
    return surface;
}

}  // namespace probebake
