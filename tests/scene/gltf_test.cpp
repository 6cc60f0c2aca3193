#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "math/box.h"
#include "scene/gltf/gltf_import.h"
#include "scene/gltf_writer.h"
#include "scene/png_writer.h"
#include "support/data.h"

namespace probebake {
namespace {

using test::gltf_triangle;
using test::GltfWriter;

std::optional<std::vector<std::byte>> nothing(const std::string&) { return std::nullopt; }

std::vector<std::byte> bytes_of(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

TriangleMesh import_text(const std::string& text, const ReadInner& read = nothing,
                         const GltfParams& params = {}) {
    return import_gltf(bytes_of(text), params, read, "m.gltf");
}

std::string problem_of(const std::string& text, const ReadInner& read = nothing,
                       const GltfParams& params = {}) {
    try {
        import_text(text, read, params);
    } catch (const IoError& error) {
        return error.what();
    }
    return "none";
}

/// The corners of a triangle.
std::array<Vec3, 3> corners(const TriangleMesh& mesh, size_t triangle) {
    const auto& v = mesh.triangles[triangle].vertices;
    return {mesh.positions[v[0]], mesh.positions[v[1]], mesh.positions[v[2]]};
}

void expect_near(const Vec3& a, const Vec3& b) {
    EXPECT_LT(glm::length(a - b), 1e-12) << a.x << ' ' << a.y << ' ' << a.z;
}

TEST(Gltf, EmbeddedAndBinaryAreTheSame) {
    const GltfWriter writer = gltf_triangle();
    for (const std::string& text : {writer.text(), writer.binary()}) {
        const TriangleMesh mesh = import_text(text);
        ASSERT_EQ(mesh.triangles.size(), 1u);
        expect_near(corners(mesh, 0)[1], Vec3(1, 0, 0));
        EXPECT_TRUE(mesh.texture_coordinates.empty());
        EXPECT_TRUE(mesh.colors.empty());
        ASSERT_EQ(mesh.materials.size(), 1u);
        EXPECT_EQ(mesh.materials[0].base_color, Rgb(1.0f));
        EXPECT_TRUE(mesh.warnings.empty());
    }
}

TEST(Gltf, BufferInAFileOfItsOwn) {
    const GltfWriter writer = gltf_triangle();
    Json document = writer.document;
    document["buffers"] = {{{"byteLength", writer.buffer.size()}, {"uri", "parts/a%20b+c.bin"}}};
    std::string asked;
    const auto read = [&](const std::string& name) {
        asked = name;
        return std::optional(bytes_of(writer.buffer));
    };
    EXPECT_EQ(import_text(document.dump(), read).triangles.size(), 1u);
    EXPECT_EQ(asked, "parts/a b+c.bin");
    EXPECT_NE(problem_of(document.dump()).find("\"parts/a b+c.bin\" is missing"),
              std::string::npos);
}

TEST(Gltf, DataUrisOfAnotherKind) {
    const GltfWriter writer = gltf_triangle();
    Json document = writer.document;
    document["buffers"] = {{{"byteLength", 36}, {"uri", "data:text/html,x"}}};
    EXPECT_EQ(problem_of(document.dump()),
              "m.gltf: a buffer is a data: URI of a kind that is not understood");
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64,AAAA";
    EXPECT_NE(problem_of(document.dump()).find("Failed to decode"), std::string::npos);
}

TEST(Gltf, NodesTransformTheirChildren) {
    GltfWriter writer = gltf_triangle();
    // A quarter turn about +Y, then twice as large and 5 m up; its child 1 m along its own +X.
    const double h = std::sqrt(0.5);
    writer.document["nodes"][0]["translation"] = {1, 0, 0};
    writer.node({{"rotation", {0, h, 0, h}},
                 {"scale", {2, 2, 2}},
                 {"translation", {0, 5, 0}},
                 {"children", {0}}});
    writer.document["scenes"][0]["nodes"] = {1};
    const TriangleMesh mesh = import_text(writer.text());
    ASSERT_EQ(mesh.triangles.size(), 1u);
    expect_near(corners(mesh, 0)[0], Vec3(0, 5, -2));
    expect_near(corners(mesh, 0)[1], Vec3(0, 5, -4));
    expect_near(corners(mesh, 0)[2], Vec3(0, 7, -2));
}

TEST(Gltf, MatricesMirrorAndTurnTheWinding) {
    GltfWriter writer = gltf_triangle();
    // Column by column: x mirrored, moved to (10, 20, 30).
    writer.document["nodes"][0]["matrix"] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1};
    const TriangleMesh mesh = import_text(writer.text());
    const auto c = corners(mesh, 0);
    expect_near(c[0], Vec3(10, 20, 30));
    // The front still faces +Z.
    expect_near(glm::cross(c[1] - c[0], c[2] - c[0]), Vec3(0, 0, 1));
    writer.document["nodes"][0]["matrix"][3] = 1;
    EXPECT_EQ(problem_of(writer.text()),
              "m.gltf: /nodes/0/matrix: expected 0, 0, 0, 1 in its last row");
}

TEST(Gltf, DeepHierarchies) {
    GltfWriter writer = gltf_triangle();
    constexpr int kDepth = 20'000;
    writer.document["nodes"] = Json::array();
    for (int i = 0; i < kDepth; ++i) {
        writer.document["nodes"].push_back({{"translation", {0, 0, 1}}, {"children", {i + 1}}});
    }
    writer.document["nodes"].push_back({{"mesh", 0}});
    expect_near(corners(import_text(writer.text()), 0)[0], Vec3(0, 0, kDepth));
    // The last node's child is the first.
    writer.document["nodes"][kDepth]["children"] = {0};
    EXPECT_EQ(problem_of(writer.text()), "m.gltf: /nodes/0: is met twice, but nodes form trees");
    Json nested = Json::array();
    for (int i = 0; i < 100; ++i) nested = Json::array({nested});
    writer.document["extras"] = nested;
    EXPECT_NE(problem_of(writer.text()).find("nested deeper than 64"), std::string::npos);
}

TEST(Gltf, InstancesOfAMesh) {
    GltfWriter writer = gltf_triangle();
    writer.node({{"mesh", 0}, {"translation", {0, 0, 7}}});
    const TriangleMesh mesh = import_text(writer.text());
    ASSERT_EQ(mesh.triangles.size(), 2u);
    expect_near(corners(mesh, 0)[1], Vec3(1, 0, 0));
    expect_near(corners(mesh, 1)[1], Vec3(1, 0, 7));
}

TEST(Gltf, ListsStripsAndFans) {
    // The corners of a square, counter-clockwise seen from +Z, and of its strip.
    const std::vector<float> square{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    for (const int mode : {4, 5, 6}) {
        GltfWriter writer;
        Json primitive = {{"mode", mode}};
        primitive["attributes"]["POSITION"] = writer.positions(square);
        if (mode == 4) {
            primitive["indices"] =
                writer.accessor("SCALAR", 5121, std::vector<uint8_t>{0, 1, 2, 0, 2, 3});
        } else if (mode == 5) {
            primitive["indices"] =
                writer.accessor("SCALAR", 5125, std::vector<uint32_t>{0, 1, 3, 2});
        }
        writer.node({{"mesh", writer.mesh(primitive)}});
        const TriangleMesh mesh = import_text(writer.text());
        ASSERT_EQ(mesh.triangles.size(), 2u) << mode;
        for (size_t i = 0; i < 2; ++i) {
            const auto c = corners(mesh, i);
            expect_near(glm::cross(c[1] - c[0], c[2] - c[0]), Vec3(0, 0, 1));
        }
    }
}

TEST(Gltf, PointsAndLinesAreLeftOut) {
    GltfWriter writer = gltf_triangle();
    writer.document["meshes"][0]["primitives"][0]["mode"] = 1;
    const TriangleMesh mesh = import_text(writer.text());
    EXPECT_TRUE(mesh.triangles.empty());
    EXPECT_EQ(mesh.warnings, std::vector<std::string>{"points and lines are left out"});
    writer.document["meshes"][0]["primitives"][0]["mode"] = 7;
    EXPECT_EQ(problem_of(writer.text()), "m.gltf: /meshes/0/primitives/0/mode: expected 0 to 6");
}

TEST(Gltf, StridedAndSparseAccessors) {
    GltfWriter writer;
    // Every other triple of floats.
    const int view = writer.buffer_view(
        std::vector<float>{0, 0, 0, 9, 9, 9, 1, 0, 0, 9, 9, 9, 0, 1, 0, 9, 9, 9});
    writer.document["bufferViews"][static_cast<size_t>(view)]["byteStride"] = 24;
    const int indices = writer.buffer_view(std::vector<uint16_t>{2});
    const int values = writer.buffer_view(std::vector<float>{0, 4, 0});
    writer.document["accessors"].push_back(
        {{"bufferView", view},
         {"componentType", 5126},
         {"count", 3},
         {"type", "VEC3"},
         {"sparse",
          {{"count", 1},
           {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
           {"values", {{"bufferView", values}}}}}});
    writer.node({{"mesh", writer.mesh({{"attributes", {{"POSITION", 0}}}})}});
    const TriangleMesh mesh = import_text(writer.text());
    expect_near(corners(mesh, 0)[1], Vec3(1, 0, 0));
    expect_near(corners(mesh, 0)[2], Vec3(0, 4, 0));
    // Without dense values the others are zeros.
    writer.document["accessors"][0].erase("bufferView");
    expect_near(corners(import_text(writer.text()), 0)[1], Vec3(0, 0, 0));
    writer.document["accessors"][0]["sparse"]["count"] = 4;
    EXPECT_EQ(problem_of(writer.text()), "m.gltf: /accessors/0: replaces 4 of 3 elements");
}

TEST(Gltf, ColoursAndNormalisedCoordinates) {
    GltfWriter writer = gltf_triangle();
    Json& attributes = writer.document["meshes"][0]["primitives"][0]["attributes"];
    attributes["COLOR_0"] = writer.accessor(
        "VEC4", 5121, std::vector<uint8_t>{255, 0, 0, 255, 0, 51, 0, 0, 0, 0, 102, 255}, true);
    attributes["TEXCOORD_0"] =
        writer.accessor("VEC2", 5123, std::vector<uint16_t>{0, 65535, 13107, 0, 0, 0}, true);
    writer.document["materials"] = {
        {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    writer.document["meshes"][0]["primitives"][0]["material"] = 0;
    writer.document["textures"] = {{{"source", 0}, {"sampler", 0}}};
    writer.document["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
    writer.document["images"] = {{{"uri", "a.png"}}};
    const std::string picture = test::rgb_png(2, std::string("\1\2\3\4\5\6", 6));
    const auto read = [&](const std::string&) { return std::optional(bytes_of(picture)); };
    const TriangleMesh mesh = import_text(writer.text(), read);
    EXPECT_EQ(mesh.colors[0], (std::array<float, 4>{1, 0, 0, 1}));
    EXPECT_EQ(mesh.colors[1], (std::array<float, 4>{0, 0.2f, 0, 0}));
    EXPECT_EQ(mesh.texture_coordinates[0], Vec2(0, 1));
    EXPECT_DOUBLE_EQ(mesh.texture_coordinates[1].x, 0.2);
    ASSERT_EQ(mesh.textures.size(), 1u);
    EXPECT_EQ(mesh.textures[0].texels[1], (std::array<uint8_t, 4>{4, 5, 6, 255}));
    EXPECT_EQ(mesh.textures[0].wrap_u, TextureWrap::kClamp);
    EXPECT_EQ(mesh.textures[0].wrap_v, TextureWrap::kMirror);
    EXPECT_EQ(mesh.materials[0].base_color_texture, 0u);
    // Missing: a warning, and the factor.
    const TriangleMesh bare = import_text(writer.text());
    EXPECT_FALSE(bare.materials[0].base_color_texture);
    ASSERT_EQ(bare.warnings.size(), 1u);
    EXPECT_NE(bare.warnings[0].find("\"a.png\" is missing"), std::string::npos);
    // Damaged: an error.
    const auto damaged = [&](const std::string&) {
        return std::optional(bytes_of(picture.substr(0, picture.size() - 5)));
    };
    EXPECT_EQ(problem_of(writer.text(), damaged).substr(0, 6), "a.png:");
}

TEST(Gltf, PicturesInsideTheFile) {
    const std::string picture = test::rgb_png(1, std::string("\7\10\11", 3));
    for (const bool in_view : {false, true}) {
        GltfWriter writer = gltf_triangle();
        Json& primitive = writer.document["meshes"][0]["primitives"][0];
        primitive["material"] = 0;
        primitive["attributes"]["TEXCOORD_1"] =
            writer.accessor("VEC2", 5126, std::vector<float>{0, 0, 1, 0, 0, 1});
        const Json texture = {{"index", 0},
                              {"extensions",
                               {{"KHR_texture_transform",
                                 {{"offset", {0.5, 0.25}}, {"scale", {2, 4}}, {"texCoord", 1}}}}}};
        writer.document["materials"] = {
            {{"emissiveFactor", {1, 0.5, 0}},
             {"emissiveTexture", texture},
             {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 10}}}}}}};
        writer.document["textures"] = {{{"source", 0}}};
        if (in_view) {
            const int view = writer.buffer_view(std::vector<char>(picture.begin(), picture.end()));
            writer.document["images"] = {{{"bufferView", view}, {"mimeType", "image/png"}}};
        } else {
            writer.document["images"] = {
                {{"uri", "data:image/png;base64," + test::base64(picture)}}};
        }
        const TriangleMesh mesh =
            import_text(in_view ? writer.binary() : writer.text(), nothing, {.emission_scale = 2});
        ASSERT_EQ(mesh.textures.size(), 1u);
        EXPECT_EQ(mesh.textures[0].texels[0], (std::array<uint8_t, 4>{7, 8, 9, 255}));
        EXPECT_EQ(mesh.materials[0].emission_texture, 0u);
        EXPECT_EQ(mesh.materials[0].emission, Rgb(20, 10, 0));
        EXPECT_EQ(mesh.texture_coordinates[1], Vec2(2.5, 0.25));
        EXPECT_EQ(mesh.texture_coordinates[2], Vec2(0.5, 4.25));
    }
}

TEST(Gltf, TextureTransformsTurnCounterClockwise) {
    GltfWriter writer = gltf_triangle();
    Json& primitive = writer.document["meshes"][0]["primitives"][0];
    primitive["material"] = 0;
    primitive["attributes"]["TEXCOORD_0"] =
        writer.accessor("VEC2", 5126, std::vector<float>{0, 0, 1, 0, 0, 1});
    const Json transform = {{"rotation", std::acos(0.0)}, {"scale", {2, 3}}, {"offset", {10, 20}}};
    writer.document["materials"] = {
        {{"pbrMetallicRoughness",
          {{"baseColorTexture",
            {{"index", 0}, {"extensions", {{"KHR_texture_transform", transform}}}}}}}}};
    writer.document["textures"] = {{{"source", 0}}};
    writer.document["images"] = {{{"uri", "a.png"}}};
    const std::string picture = test::rgb_png(1, "abc");
    const auto read = [&](const std::string&) { return std::optional(bytes_of(picture)); };
    const TriangleMesh mesh = import_text(writer.text(), read);
    // v points down: +u turns to where v is less.
    expect_near(Vec3(mesh.texture_coordinates[0], 0), Vec3(10, 20, 0));
    expect_near(Vec3(mesh.texture_coordinates[1], 0), Vec3(10, 18, 0));
    expect_near(Vec3(mesh.texture_coordinates[2], 0), Vec3(13, 20, 0));
}

TEST(Gltf, AlphaModes) {
    GltfWriter writer = gltf_triangle();
    writer.document["materials"] = {
        {{"pbrMetallicRoughness", {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}}}},
        {{"alphaMode", "MASK"}, {"alphaCutoff", 0.75}, {"doubleSided", true}},
        {{"alphaMode", "BLEND"}, {"extensions", {{"KHR_materials_unlit", Json::object()}}}}};
    const TriangleMesh mesh = import_text(writer.text());
    EXPECT_EQ(mesh.materials[0].alpha_cutoff, 0.0f);
    EXPECT_EQ(mesh.materials[0].base_color, Rgb(0.1f, 0.2f, 0.3f));
    EXPECT_FALSE(mesh.materials[0].double_sided);
    EXPECT_EQ(mesh.materials[1].alpha_cutoff, 0.75f);
    EXPECT_TRUE(mesh.materials[1].double_sided);
    EXPECT_EQ(mesh.materials[2].alpha_cutoff, 0.5f);
    ASSERT_EQ(mesh.warnings.size(), 1u);
    EXPECT_NE(mesh.warnings[0].find("blended"), std::string::npos);
}

TEST(Gltf, DirectionalLights) {
    GltfWriter writer = gltf_triangle();
    writer.document["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "directional"}, {"intensity", 3}, {"color", {1, 0.5, 0.25}}},
        {{"type", "point"}}};
    // A quarter turn about +X turns −Z to +Y.
    const double h = std::sqrt(0.5);
    for (const int light : {0, 1}) {
        writer.node({{"rotation", {h, 0, 0, h}},
                     {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
    }
    const TriangleMesh mesh = import_text(writer.text());
    ASSERT_EQ(mesh.suns.size(), 1u);
    expect_near(mesh.suns[0].direction, Vec3(0, 1, 0));
    EXPECT_EQ(mesh.suns[0].irradiance, Rgb(3.0f, 1.5f, 0.75f));
    EXPECT_EQ(mesh.warnings.size(), 1u);
}

TEST(Gltf, RefusesWithThePlace) {
    const auto with = [](const std::string& pointer, const Json& value) {
        GltfWriter writer = gltf_triangle();
        writer.document[Json::json_pointer(pointer)] = value;
        return problem_of(writer.text()).substr(sizeof("m.gltf: ") - 1);
    };
    EXPECT_EQ(with("/nodes/0/mesh", 1), "/nodes/0/mesh: is 1, but /meshes has 1 elements");
    EXPECT_EQ(with("/nodes/0/mesh", int64_t{1} << 32),
              "/nodes/0/mesh: expected an integer from 0 to 2147483647");
    EXPECT_EQ(with("/nodes/0/mesh", 0.0),
              "/nodes/0/mesh: expected an integer from 0 to 2147483647");
    EXPECT_EQ(with("/nodes/0/children", {0}), "/nodes/0: is met twice, but nodes form trees");
    EXPECT_EQ(with("/scenes/0/nodes", {0, 0}), "/nodes/0: is met twice, but nodes form trees");
    EXPECT_EQ(with("/nodes/0/scale", {1, 1}), "/nodes/0/scale: expected 3 numbers");
    EXPECT_EQ(with("/nodes/0/rotation", {0, 0, 0, 0}),
              "/nodes/0/rotation: expected a quaternion of length 1");
    EXPECT_EQ(with("/meshes/0/primitives/0/attributes", {{"NORMAL", 0}}),
              "/meshes/0/primitives/0/attributes: expected a POSITION");
    EXPECT_EQ(with("/accessors/0/count", 4), "/accessors/0: needs 48 bytes, /bufferViews/0 has 36");
    EXPECT_EQ(with("/accessors/0/byteOffset", 2147483647),
              "/accessors/0: needs 2147483683 bytes, /bufferViews/0 has 36");
    EXPECT_EQ(with("/accessors/0/componentType", 5130),
              "/accessors/0: is of a type that is not expected here");
    EXPECT_EQ(with("/accessors/0/type", "VEC2"), "/accessors/0: is a position, expected a VEC3");
    EXPECT_EQ(with("/accessors/0/componentType", 5123).substr(0, 13), "/accessors/0:");
    EXPECT_EQ(with("/bufferViews/0/byteLength", 37),
              "/bufferViews/0: holds 37 bytes and ends at byte 37 of buffer 0, which has 36");
    EXPECT_EQ(with("/asset/version", "1.0"), "/asset/version: expected \"2.0\"");
    EXPECT_EQ(
        with("/extensionsRequired", {"KHR_draco_mesh_compression"}),
        "/extensionsRequired/0: needs KHR_draco_mesh_compression, expected a mesh that is not "
        "compressed");
    EXPECT_EQ(with("/extensionsRequired", {"X_new"}),
              "/extensionsRequired/0: needs X_new, which is not understood");
    EXPECT_EQ(with("/images", {{{"uri", "../x.png"}}}).substr(0, 23), "/images/0/uri: is \"../x");
    EXPECT_EQ(with("/images", {{{"uri", "https://h/x.png"}}}).substr(0, 14), "/images/0/uri:");
    EXPECT_EQ(with("/images", {{{"uri", "%2e%2e/x.png"}}}).substr(0, 14), "/images/0/uri:");
}

TEST(Gltf, RefusesPositionsAndIndices) {
    GltfWriter writer;
    const int positions =
        writer.positions({0, 0, 0, 1, 0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0});
    const int indices = writer.accessor("SCALAR", 5125, std::vector<uint32_t>{0, 1, 4000000000u});
    const int mesh = writer.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
    writer.node({{"mesh", mesh}});
    EXPECT_EQ(problem_of(writer.text()), "m.gltf: /accessors/0: position 2 is not finite");
    writer.document["accessors"][0]["count"] = 2;
    EXPECT_EQ(problem_of(writer.text()),
              "m.gltf: /accessors/1: element 2 is index 4000000000, but there are 2 positions");
    EXPECT_EQ(problem_of(writer.text(), nothing, {.limits = {.max_vertices = 1}}),
              "m.gltf: /accessors/0: has 2 elements, expected 1 to 1");
    EXPECT_EQ(problem_of(writer.text(), nothing, {.limits = {.max_triangles = 0}}),
              "m.gltf: /accessors/1: has 3 elements, expected 1 to 0");
}

TEST(Gltf, RefusesTruncatedFiles) {
    const std::string text = gltf_triangle().text();
    const std::string binary = gltf_triangle().binary();
    for (size_t size = 0; size < binary.size(); ++size) {
        EXPECT_NE(problem_of(binary.substr(0, size)), "none") << size;
    }
    for (size_t size = 0; size < text.size(); ++size) {
        EXPECT_NE(problem_of(text.substr(0, size)), "none") << size;
    }
    std::string longer = binary;
    longer[8] = static_cast<char>(longer[8] + 4);
    EXPECT_EQ(problem_of(longer).substr(0, 33), "m.gltf: offset 8: the header says");
    // The second chunk claims the eight bytes behind the end.
    std::string chunk = gltf_triangle().binary();
    const size_t at = chunk.size() - 36 - 8;
    chunk[at] = static_cast<char>(chunk[at] + 8);
    EXPECT_NE(problem_of(chunk).find("a chunk needs"), std::string::npos);
}

TEST(Gltf, LivingRoom) {
    const auto path = test::data_file("mesh/living_room/living_room.glb");
    if (!path) GTEST_SKIP() << "no mesh/living_room in the scene data";
    const ReadInner read = files_beneath(path->parent_path());
    const TriangleMesh mesh = import_gltf(*read("living_room.glb"), {}, read, "living_room.glb");
    EXPECT_EQ(mesh.triangles.size(), 5088u);
    EXPECT_EQ(mesh.materials.size(), 7u);
    EXPECT_TRUE(mesh.textures.empty());
    EXPECT_TRUE(mesh.warnings.empty());
}

TEST(Gltf, DutchShip) {
    const auto path = test::data_file("mesh/dutch_ship_medium/dutch_ship_medium_1k.gltf");
    if (!path) GTEST_SKIP() << "no mesh/dutch_ship_medium in the scene data";
    const ReadInner read = files_beneath(path->parent_path());
    const TriangleMesh mesh = import_gltf(*read("dutch_ship_medium_1k.gltf"), {}, read, "ship");
    EXPECT_EQ(mesh.triangles.size(), 69162u);
    EXPECT_EQ(mesh.materials.size(), 3u);
    EXPECT_EQ(mesh.positions.size(), 35903u + 24621u + 4020u);
    // Nine pictures, of which the three base colours are shown.
    ASSERT_EQ(mesh.textures.size(), 3u);
    for (const Texture& texture : mesh.textures) EXPECT_EQ(texture.width_px, 1024);
    EXPECT_EQ(mesh.materials[2].alpha_cutoff, 0.5f);
    Box bounds = empty_box();
    for (const Vec3& p : mesh.positions) bounds = join(bounds, p);
    EXPECT_LT(glm::length(bounds.low - Vec3(-10.3257, -2.0, -3.488)), 1e-3);
    EXPECT_LT(glm::length(bounds.high - Vec3(13.7447, 22.6571, 3.3208)), 1e-3);
    EXPECT_TRUE(mesh.warnings.empty());
}

}  // namespace
}  // namespace probebake
