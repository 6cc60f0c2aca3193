#include <gtest/gtest.h>

#include <map>

#include "scene/obj/obj_import.h"
#include "scene/png_writer.h"
#include "support/data.h"

namespace probebake {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

/// Files by name.
using Folder = std::map<std::string, std::string>;

ReadInner reader_of(const Folder& folder) {
    return [folder](const std::string& name) -> std::optional<std::vector<std::byte>> {
        const auto at = folder.find(name);
        if (at == folder.end()) return std::nullopt;
        return bytes_of(at->second);
    };
}

TriangleMesh import_text(const std::string& text, const Folder& folder = {},
                         const ObjParams& params = {}) {
    return import_obj(text, params, reader_of(folder), "m.obj");
}

std::string problem_of(const std::string& text, const Folder& folder = {},
                       const ObjParams& params = {}) {
    try {
        import_text(text, folder, params);
    } catch (const IoError& error) {
        return error.what();
    }
    return "none";
}

double area_of(const TriangleMesh& mesh) {
    double area = 0.0;
    for (const MeshTriangle& t : mesh.triangles) {
        const Vec3& a = mesh.positions[t.vertices[0]];
        area += 0.5 *
                glm::cross(mesh.positions[t.vertices[1]] - a, mesh.positions[t.vertices[2]] - a).z;
    }
    return area;
}

TEST(Obj, IndicesOfAllForms) {
    const std::string vertices =
        "v 0 0 0\nv 1 0 0 # a comment\n  v\t0 1.0e0 +0\r\n"
        "vt 0 0\nvt 1 0.25\nvt 0 1 0\nvn 0 0 1\n";
    for (const char* face : {"f 1 2 3", "f 1/1 2/2 3/3", "f 1/1/1 2/2/1 3/3/1",
                             "f -3//1 -2//1 -1//1", "f -3/-3 -2/-2 -1/-1"}) {
        const TriangleMesh mesh = import_text(vertices + face);
        ASSERT_EQ(mesh.triangles.size(), 1u) << face;
        EXPECT_EQ(mesh.positions.size(), 3u);
        EXPECT_EQ(mesh.positions[1], Vec3(1, 0, 0));
        EXPECT_EQ(mesh.positions[2], Vec3(0, 1, 0));
        if (std::string(face).find("/3") != std::string::npos) {
            EXPECT_EQ(mesh.texture_coordinates[1], Vec2(1, 0.75));  // from the top
        }
        EXPECT_EQ(mesh.materials.size(), 1u);
        EXPECT_EQ(mesh.materials[0].base_color, kNoMaterialAlbedo);
    }
    // A byte order mark hides no vertex.
    EXPECT_EQ(import_text("\xEF\xBB\xBF" + vertices + "f 1 2 3").positions[1], Vec3(1, 0, 0));
    // A vertex may follow the face that uses it.
    EXPECT_EQ(import_text("f 1 2 3\n" + vertices).triangles.size(), 1u);
}

TEST(Obj, ConcaveFaces) {
    // An L of area 3, a comb of area 8, a square with a hole on a bridge of area 8.
    const std::string l = "v 0 0 5\nv 2 0 5\nv 2 1 5\nv 1 1 5\nv 1 2 5\nv 0 2 5\nf 1 2 3 4 5 6\n";
    EXPECT_EQ(import_text(l).triangles.size(), 4u);
    EXPECT_DOUBLE_EQ(area_of(import_text(l)), 3.0);
    const std::string comb =
        "v 0 0 0\nv 5 0 0\nv 5 2 0\nv 4 2 0\nv 4 1 0\nv 3 1 0\nv 3 2 0\nv 2 2 0\nv 2 1 0\n"
        "v 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6 7 8 9 10 11 12\n";
    EXPECT_DOUBLE_EQ(area_of(import_text(comb)), 8.0);
    for (const MeshTriangle& t : import_text(comb).triangles) {
        const TriangleMesh mesh = import_text(comb);
        const Vec3& a = mesh.positions[t.vertices[0]];
        EXPECT_GT(
            glm::cross(mesh.positions[t.vertices[1]] - a, mesh.positions[t.vertices[2]] - a).z,
            0.0);
    }
    const std::string ring =
        "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nv 1 1 0\nv 1 2 0\nv 2 2 0\nv 2 1 0\n"
        "f 1 2 3 4 1 5 6 7 8 5\n";
    EXPECT_DOUBLE_EQ(area_of(import_text(ring)), 8.0);
    EXPECT_EQ(import_text(ring).triangles.size(), 8u);
}

TEST(Obj, ManyCorners) {
    std::string circle;
    std::string star;
    for (int i = 0; i < 2000; ++i) {
        const double a = i * 6.283185307179586 / 2000;
        const double r = i % 2 == 0 ? 1.0 : 0.9;
        circle += "v " + std::to_string(std::cos(a)) + " " + std::to_string(std::sin(a)) + " 0\n";
        star +=
            "v " + std::to_string(r * std::cos(a)) + " " + std::to_string(r * std::sin(a)) + " 0\n";
    }
    std::string face = "f";
    for (int i = 1; i <= 2000; ++i) face += " " + std::to_string(i);
    EXPECT_EQ(problem_of(star + face),
              "m.obj: a concave face has 2000 corners, expected at most 1024");
    std::string short_face = "f";
    for (int i = 1; i <= 1000; ++i) short_face += " " + std::to_string(i);
    EXPECT_EQ(import_text(star + short_face).triangles.size(), 998u);
}

TEST(Obj, Materials) {
    const std::string picture = test::rgb_png(1, std::string("\7\10\11", 3));
    const Folder folder = {{"my materials.mtl",
                            "newmtl plain # 1\nKd 0.1 0.2 0.3\nKe 4 5 6\n"
                            "newmtl wood\nmap_Kd -s 1 1 -clamp on tex\\wood.png\n"
                            "newmtl gone\nmap_Kd gone.png\nKd 0.5\nd 0.25\n"
                            "newmtl lamp\nKd 0 0 0\nmap_Ke tex/wood.png\nTr 0.1\n"},
                           {"tex/wood.png", picture}};
    const std::string obj =
        "mtllib my materials.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl plain # 1\nf 1 2 3\n"
        "usemtl wood\nf 1 2 3\nusemtl gone\nf 1 2 3\nusemtl lamp\nf 1 2 3\nusemtl who\nf 1 2 3\n";
    const TriangleMesh mesh = import_text(obj, folder);
    ASSERT_EQ(mesh.triangles.size(), 5u);
    const auto material = [&](size_t i) { return mesh.materials[mesh.triangles[i].material]; };
    EXPECT_EQ(material(0).name, "plain # 1");
    EXPECT_EQ(material(0).base_color, Rgb(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(material(0).emission, Rgb(4, 5, 6));
    EXPECT_EQ(material(1).base_color, Rgb(1.0f));
    ASSERT_TRUE(material(1).base_color_texture);
    EXPECT_EQ(mesh.textures[*material(1).base_color_texture].wrap_u, TextureWrap::kClamp);
    EXPECT_EQ(material(2).base_color, Rgb(0.5f));
    EXPECT_FALSE(material(2).base_color_texture);
    EXPECT_EQ(material(2).alpha, 0.25f);
    EXPECT_EQ(material(2).alpha_cutoff, 0.5f);
    EXPECT_EQ(material(3).emission, Rgb(1.0f));
    EXPECT_TRUE(material(3).emission_texture);
    EXPECT_EQ(mesh.textures.size(), 2u);  // clamped and repeated
    EXPECT_FLOAT_EQ(material(3).alpha, 0.9f);
    EXPECT_EQ(material(4).base_color, kNoMaterialAlbedo);
    EXPECT_EQ(mesh.warnings.size(), 3u);  // options, gone.png, who
    // Another file instead; missing ones leave grey.
    const Folder other = {{"other.mtl", "newmtl wood\nKd 0 1 0\n"}};
    const TriangleMesh green = import_text(obj, other, {.materials = "other.mtl", .limits = {}});
    EXPECT_EQ(green.materials[green.triangles[1].material].base_color, Rgb(0, 1, 0));
    const TriangleMesh grey = import_text(obj);
    EXPECT_EQ(grey.materials[grey.triangles[0].material].base_color, kNoMaterialAlbedo);
}

TEST(Obj, RefusesWithTheLine) {
    const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    EXPECT_EQ(problem_of("v 0 0\n"),
              "m.obj: line 1: expected a coordinate, a finite number, not the end of the line");
    EXPECT_EQ(problem_of("\n\nv 0 x 0\n"),
              "m.obj: line 3: expected a coordinate, a finite number, not \"x\"");
    for (const char* number : {"nan", "inf", "1e999", "1e-99999999999", "0x10", "--1", "1e",
                               "0e2147483649", "0e999", "0.0e-309", "0e9993"}) {
        EXPECT_EQ(problem_of(std::string("v 0 0 ") + number).substr(0, 14), "m.obj: line 1:")
            << number;
    }
    EXPECT_EQ(problem_of(v + "f 1 2 4"), "m.obj: line 4: index 4, but the file has 3 vertices");
    EXPECT_EQ(problem_of(v + "f 1 2 -4"), "m.obj: line 4: index -4, but only 3 vertices before it");
    EXPECT_EQ(problem_of(v + "f 1 2 0"),
              "m.obj: line 4: expected an index from 1 on, or below 0, not \"0\"");
    EXPECT_EQ(problem_of(v + "f 1 2 99999999999"),
              "m.obj: line 4: expected an index from 1 on, or below 0, not \"99999999999\"");
    EXPECT_EQ(problem_of(v + "f 1/1 2/1 3/1"),
              "m.obj: line 4: index 1, but the file has 0 texture coordinates");
    EXPECT_EQ(problem_of(v + "f 1 2"),
              "m.obj: line 4: expected three corners of a face or more, not the end of the line");
    EXPECT_EQ(
        problem_of(v + "f 1 2 3\nf 1 2 3", {}, {.materials = {}, .limits = {.max_triangles = 1}}),
        "m.obj: has more than 1 triangles");
    EXPECT_EQ(problem_of(v, {}, {.materials = {}, .limits = {.max_vertices = 2}}),
              "m.obj: has more than 2 vertices");
    const Folder bad = {{"a.mtl", "newmtl a\nKd 1 2\n"},
                        {"b.mtl", "Kd 1 1 1\n"},
                        {"c.mtl", "newmtl c\nd 2\n"},
                        {"d.mtl", "newmtl d\nmap_Kd ../x.png\n"}};
    EXPECT_EQ(problem_of("mtllib a.mtl", bad),
              "a.mtl: line 2: expected a part of a colour, a finite number, not the end of the "
              "line");
    EXPECT_EQ(problem_of("mtllib b.mtl", bad).substr(0, 14), "b.mtl: line 1:");
    EXPECT_EQ(problem_of("mtllib c.mtl", bad).substr(0, 14), "c.mtl: line 2:");
    EXPECT_EQ(problem_of("mtllib d.mtl", bad).substr(0, 23), "m.obj: refers to \"../x.");
    EXPECT_EQ(problem_of("mtllib /etc/passwd", bad).substr(0, 22), "m.obj: refers to \"/etc");
}

TEST(Obj, Pandora) {
    const auto path = test::data_file("mesh/pandora/pandora.obj");
    if (!path) GTEST_SKIP() << "no mesh/pandora in the scene data";
    const ReadInner read = files_beneath(path->parent_path());
    const auto bytes = read("pandora.obj");
    const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    const TriangleMesh mesh =
        import_obj(text, {.materials = "pandora_kd.mtl", .limits = {}}, read, "pandora.obj");
    EXPECT_EQ(mesh.triangles.size(), 60810u);
    EXPECT_EQ(mesh.materials.size(), 206u);
    size_t slots = 0;
    for (const MeshMaterial& material : mesh.materials) slots += material.emission != Rgb(0.0f);
    EXPECT_EQ(slots, 32u);
    size_t triangles = 0;
    for (const MeshTriangle& triangle : mesh.triangles) {
        triangles += mesh.materials[triangle.material].emission != Rgb(0.0f);
    }
    EXPECT_EQ(triangles, 645u);
    EXPECT_TRUE(mesh.warnings.empty());
    // The materials that came with it name textures that did not.
    const TriangleMesh bare = import_obj(text, {}, read, "pandora.obj");
    EXPECT_EQ(bare.triangles.size(), 60810u);
    EXPECT_EQ(bare.warnings.size(), 35u);
}

}  // namespace
}  // namespace probebake
