// Files of meshes and of heights with numbers that are none.
#include <limits>
#include <span>

#include "image/exr_file.h"
#include "image/preview.h"
#include "scene/gltf/gltf_import.h"
#include "scene/heightmap/height_exr.h"
#include "scene/nff/nff_file.h"
#include "scene/obj/obj_import.h"
#include "volume_study/stability_input.h"

namespace probebake::volume_study {
namespace {

constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()};

std::vector<std::byte> bytes_of(const std::string& text) {
    const auto all = std::as_bytes(std::span(text));
    return {all.begin(), all.end()};
}

Refusals obj_numbers() {
    const std::string mesh =
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 .5\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\n"
        "f 1/1 2/2 3/3\n";
    const std::string materials = "newmtl a\nKd 0.5 0.5 0.5\nKe 1 2 3\nd 1\n";
    const auto import = [](const std::string& obj, const std::string& mtl) {
        const ReadInner read = [&](const std::string&) { return std::optional(bytes_of(mtl)); };
        import_obj(obj, {}, read, "a.obj");
    };
    import(mesh, materials);  // as it stands it is a mesh
    Refusals got = with_every_word(mesh, [&](const std::string& s) { import(s, materials); });
    got += with_every_word(materials, [&](const std::string& s) { import(mesh, s); });
    return got;
}

Refusals nff_numbers() {
    const std::string text =
        "v\nfrom 1 2 3\nat 0 0 0\nup 0 0 1\nangle 45\nhither 0.5\nresolution 512 256\n"
        "b 0.1 0.2 0.3\nl 4 3 2\nf 1 0.9 0.7 0.5 0.5 30 0 1\ns 0 0 0 0.5\n"
        "c\n0 0 0 1\n0 0 2 0.5\np 3\n0 0 0\n1 0 0\n0 1 0\n";
    parse_nff(text, "a.nff");
    return with_every_word(text, [](const std::string& s) { parse_nff(s, "a.nff"); });
}

/// Numbers of the document and of its buffer: positions, texture coordinates, colours.
Refusals gltf_numbers() {
    const std::string document = R"({"asset": {"version": "2.0"}, "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0, 1],
                   "scale": [1, 1, 1]}],
        "images": [{"uri": "a.png"}], "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1],
                                                "baseColorTexture": {"index": 0}},
                       "emissiveFactor": [1, 0.5, 0.25], "alphaMode": "MASK", "alphaCutoff": 0.5}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 2},
                                    "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36},
                        {"buffer": 0, "byteOffset": 36, "byteLength": 24},
                        {"buffer": 0, "byteOffset": 60, "byteLength": 36}],
        "buffers": [{"byteLength": 96, "uri": "a.bin"}]})";
    const std::vector<float> values = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1,
                                       0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::vector<std::byte> picture = encode_image_png(Image(2, 2), {});
    const auto import = [&](const std::string& json, const std::vector<float>& buffer) {
        const ReadInner read = [&](const std::string& name) {
            if (name == "a.png") return std::optional(picture);
            const auto all = std::as_bytes(std::span(buffer));
            return std::optional(std::vector<std::byte>(all.begin(), all.end()));
        };
        import_gltf(std::as_bytes(std::span(json)), {}, read, "a.gltf");
    };
    import(document, values);
    Refusals got = with_every_number(document, [&](const std::string& s) { import(s, values); });
    for (size_t i = 0; i < values.size(); ++i) {
        for (const float bad : kBad) {
            std::vector<float> broken = values;
            broken[i] = bad;
            got.expect_refusal([&] { import(document, broken); });
        }
    }
    return got;
}

Refusals heights() {
    Refusals got;
    for (size_t i = 0; i < 4; ++i) {
        for (const float bad : kBad) {
            std::vector<float> values(4, 1.0f);
            values[i] = bad;
            const auto* first = reinterpret_cast<const std::byte*>(values.data());
            const std::vector<ExrChannel<const std::byte>> channels = {{"Y", Imf::FLOAT, first, 4}};
            const auto file = encode_exr(Imf::Header(2, 2), channels);
            got.expect_refusal([&] { read_height_exr(file, "a.exr"); });
        }
    }
    return got;
}

}  // namespace

std::vector<StabilityCase> mesh_input_cases() {
    return {refused_numbers("numbers of OBJ and MTL files", obj_numbers()),
            refused_numbers("numbers of NFF files", nff_numbers()),
            refused_numbers("numbers of glTF documents and their buffers", gltf_numbers()),
            refused_numbers("heights in metres, OpenEXR", heights())};
}

}  // namespace probebake::volume_study
