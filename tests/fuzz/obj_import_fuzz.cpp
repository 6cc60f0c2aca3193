// import_obj on anything: a sound mesh, or an IoError. What follows a line "---" is the text of its
// material files; textures are missing.
#include "fuzz/mesh_checks.h"
#include "scene/obj/obj_import.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace probebake;
    constexpr std::string_view kLine = "\n---\n";
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const size_t line = std::min(text.find(kLine), text.size());
    const std::string_view obj = text.substr(0, line);
    const std::string_view mtl = text.substr(std::min(line + kLine.size(), text.size()));
    const auto read = [&](const std::string& name) -> std::optional<std::vector<std::byte>> {
        require(is_inner_name(name));
        if (!name.ends_with(".mtl")) return std::nullopt;
        const auto bytes = std::as_bytes(std::span(mtl));
        return std::vector<std::byte>(bytes.begin(), bytes.end());
    };
    const ObjParams params{
        .materials = {},
        .limits = {.max_triangles = 10'000, .max_vertices = 10'000, .max_texels = 100'000}};
    try {
        const TriangleMesh mesh = import_obj(obj, params, read, "fuzz.obj");
        require_sound(mesh);
        require(mesh.triangles.size() <= params.limits.max_triangles);
        obj_references(obj, params, read, "fuzz.obj");
    } catch (const IoError&) {
    }
    return 0;
}
