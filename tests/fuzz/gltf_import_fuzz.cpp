// import_gltf on anything: a sound mesh, or an IoError. Every file that it refers to holds the same
// bytes as it does.
#include "fuzz/mesh_checks.h"
#include "scene/gltf/gltf_import.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace probebake;
    const auto bytes = std::as_bytes(std::span(data, size));
    const auto read = [&](const std::string& name) {
        require(is_inner_name(name));
        return std::optional(std::vector<std::byte>(bytes.begin(), bytes.end()));
    };
    const GltfParams params{
        .limits = {.max_triangles = 10'000, .max_vertices = 10'000, .max_texels = 100'000}};
    try {
        const TriangleMesh mesh = import_gltf(bytes, params, read, "fuzz.gltf");
        require_sound(mesh);
        require(mesh.triangles.size() <= params.limits.max_triangles);
        require(mesh.positions.size() <= params.limits.max_vertices);
    } catch (const IoError&) {
    }
    return 0;
}
