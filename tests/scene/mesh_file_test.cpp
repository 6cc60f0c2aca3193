#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "io/file.h"
#include "io/spec_error.h"
#include "scene/folder_files.h"
#include "scene/gltf_writer.h"
#include "scene/nff/nff_mesh.h"
#include "scene/scene_library.h"
#include "support/data.h"

namespace probebake {
namespace {

class MeshFileTest : public testing::Test {
  protected:
    MeshFileTest()
        : folder_(std::filesystem::path(testing::TempDir()) / "probebake-mesh-file" /
                  testing::UnitTest::GetInstance()->current_test_info()->name()) {
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_ / "parts");
    }
    ~MeshFileTest() override { std::filesystem::remove_all(folder_); }

    void write(const std::string& name, const std::string& text) {
        write_file_atomically(folder_ / name, text);
    }
    SceneFile scene(const std::string& fields) {
        write("s.json", "{" + fields + "}");
        return read_scene_file(folder_ / "s.json");
    }
    std::string problem_of(const std::string& fields) {
        try {
            scene(fields);
        } catch (const SpecError& error) {
            return error.what();
        }
        return "none";
    }

    std::filesystem::path folder_;
};

TEST_F(MeshFileTest, FieldsOfAMesh) {
    const SceneFile file = scene(
        R"("type": "obj", "file": "m.obj", "materials": "m.mtl", "resolution": 500, "up": "z",
           "unit_m": 0.125, "emission_scale": 10)");
    ASSERT_TRUE(file.mesh);
    EXPECT_EQ(file.mesh->path, folder_ / "m.obj");
    EXPECT_EQ(file.mesh->materials, "m.mtl");
    EXPECT_EQ(file.mesh->resolution, 500);
    EXPECT_FALSE(file.mesh->voxel_size_m);
    EXPECT_TRUE(file.mesh->z_up);
    EXPECT_EQ(file.mesh->unit_m, 0.125);
    EXPECT_EQ(file.mesh->emission_scale, 10.0);
    EXPECT_EQ(problem_of(R"("type": "gltf", "file": "m.glb")"), "/voxel_size_m: is required");
    EXPECT_EQ(problem_of(R"("type": "gltf", "file": "m.glb", "voxel_size_m": 1, "resolution": 2)"),
              "/resolution: expected either voxel_size_m or resolution");
    EXPECT_EQ(problem_of(R"("type": "nff", "file": "m.nff", "resolution": 65537)"),
              "/resolution: is 65537, expected an integer from 1 to 65534");
    EXPECT_NE(problem_of(R"("type": "gltf", "file": "m.glb", "voxel_size_m": 1, "up": "z")"),
              "none");
    EXPECT_NE(problem_of(R"("type": "obj", "file": "../m.obj", "voxel_size_m": 1)"), "none");
    EXPECT_NE(problem_of(R"("type": "obj", "file": "m.obj", "materials": "parts/m.mtl",
                            "voxel_size_m": 1)"),
              "none");
}

TEST_F(MeshFileTest, SidesAndSolids) {
    write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string fields = R"("type": "obj", "file": "m.obj", "voxel_size_m": 0.1)";
    const SceneFile plain = scene(fields);
    EXPECT_FALSE(plain.mesh->solid);
    EXPECT_TRUE(load_mesh(*plain.mesh).materials.at(0).double_sided);
    EXPECT_TRUE(load_scene(plain).surface.empty());
    const SceneFile sided = scene(fields + R"(, "two_sided": false, "solid": true)");
    EXPECT_FALSE(load_mesh(*sided.mesh).materials.at(0).double_sided);
    const Scene loaded = load_scene(sided, folder_ / "cache");
    EXPECT_EQ(loaded.surface.triangles.size(), 1u);
    EXPECT_EQ(loaded.surface.one_sided, 1u);
    ASSERT_EQ(loaded.warnings.size(), 1u);
    EXPECT_EQ(loaded.warnings[0].substr(0, 18), "nothing was filled");
    // And out of the cache; where its triangles are damaged or gone, all is made anew.
    const auto cached = find_cached_scene(sided, folder_ / "cache");
    ASSERT_TRUE(cached);
    EXPECT_EQ(cached->surface.triangles, loaded.surface.triangles);
    EXPECT_EQ(cached->surface.one_sided, 1u);
    const std::filesystem::path kept = folder_ / "cache" / (loaded.sha256 + ".surface");
    std::filesystem::resize_file(kept, std::filesystem::file_size(kept) - 1);
    EXPECT_FALSE(find_cached_scene(sided, folder_ / "cache"));
    EXPECT_EQ(load_scene(sided, folder_ / "cache").surface.one_sided, 1u);
    remove_cached_scene(sided, loaded.sha256, folder_ / "cache");
    EXPECT_TRUE(std::filesystem::is_empty(folder_ / "cache"));
    EXPECT_NE(
        problem_of(R"("type": "gltf", "file": "m.glb", "voxel_size_m": 1, "two_sided": true)"),
        "none");
}

TEST_F(MeshFileTest, UnitsAndAxes) {
    write("m.obj", "v 0 0 0\nv 80 0 0\nv 0 40 16\nf 1 2 3\n");
    const SceneFile file =
        scene(R"("type": "obj", "file": "m.obj", "resolution": 100, "up": "z", "unit_m": 0.125)");
    const TriangleMesh mesh = load_mesh(*file.mesh);
    EXPECT_EQ(mesh.positions[1], Vec3(10, 0, 0));
    EXPECT_EQ(mesh.positions[2], Vec3(0, 2, -5));
    EXPECT_DOUBLE_EQ(mesh_voxel_size_m(*file.mesh, mesh), 0.1);
    const SceneFile fine = scene(R"("type": "obj", "file": "m.obj", "voxel_size_m": 0.001)");
    EXPECT_THROW(mesh_voxel_size_m(*fine.mesh, load_mesh(*fine.mesh)), IoError);
    write("m.obj", "v 0 0 0\n");
    EXPECT_THROW(load_mesh(*file.mesh), IoError);
}

TEST_F(MeshFileTest, HashCoversWhatIsReferredTo) {
    const test::GltfWriter writer = test::gltf_triangle();
    Json document = writer.document;
    document["buffers"] = {{{"byteLength", writer.buffer.size()}, {"uri", "parts/m.bin"}}};
    document["images"] = {{{"uri", "parts/a.png"}}};
    write("m.gltf", document.dump());
    write("parts/m.bin", writer.buffer);
    const std::string gltf = R"("type": "gltf", "file": "m.gltf", "voxel_size_m": 1)";
    const std::string missing = content_sha256(scene(gltf));
    write("parts/a.png", "x");
    const std::string there = content_sha256(scene(gltf));
    EXPECT_NE(there, missing);
    std::string changed = writer.buffer;
    changed[0] = 1;
    write("parts/m.bin", changed);
    EXPECT_NE(content_sha256(scene(gltf)), there);
    write("parts/m.bin", writer.buffer);
    EXPECT_EQ(content_sha256(scene(gltf)), there);

    write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("m.mtl", "newmtl a\nmap_Kd parts/t.png\n");
    const std::string obj = R"("type": "obj", "file": "m.obj", "voxel_size_m": 1)";
    const std::string first = content_sha256(scene(obj));
    write("parts/t.png", "y");
    const std::string second = content_sha256(scene(obj));
    EXPECT_NE(second, first);
    write("m.mtl", "newmtl b\nmap_Kd parts/t.png\n");
    EXPECT_NE(content_sha256(scene(obj)), second);
}

TEST_F(MeshFileTest, NothingLeadsOutOfTheFolder) {
    const test::GltfWriter writer = test::gltf_triangle();
    Json document = writer.document;
    document["buffers"] = {{{"byteLength", writer.buffer.size()}, {"uri", "parts/link.bin"}}};
    write("m.gltf", document.dump());
    write("outside.bin", writer.buffer);
    std::filesystem::create_symlink(folder_ / "outside.bin", folder_ / "parts/link.bin");
    const SceneFile file = scene(R"("type": "gltf", "file": "m.gltf", "voxel_size_m": 1)");
    EXPECT_THROW(load_mesh(*file.mesh), IoError);
    EXPECT_THROW(content_sha256(file), IoError);
    for (const char* name :
         {"", ".", "..", "a/..", "../a", "a//b", "/a", "a/", "a\\b", "c:a", "a\nb", "file:///a"}) {
        EXPECT_FALSE(is_inner_name(name)) << name;
    }
    for (const char* name : {"a", "a b/c.png", "..a", "~", "$HOME", "a/.b"}) {
        EXPECT_TRUE(is_inner_name(name)) << name;
    }
}

TEST_F(MeshFileTest, NffAsTriangles) {
    // A sphere of radius 2, a cylinder of radius 1 and length 3, an L of area 3.
    const NffScene scene = parse_nff(
        "f 1 0.5 0 0.5 0 0 0 1\ns 10 0 0 2\nc 0 0 0 1 0 3 0 1\n"
        "p 6 0 0 5 2 0 5 2 1 5 1 1 5 1 2 5 0 2 5\ns 20 0 0 -2\n",
        "m.nff");
    const TriangleMesh mesh = nff_mesh(scene, {.tolerance = 0.01, .limits = {}}, "m.nff");
    EXPECT_EQ(mesh.materials[0].base_color, Rgb(0.5f, 0.25f, 0.0f));
    double sphere_volume = 0.0;
    double inward_volume = 0.0;
    double cylinder_area = 0.0;
    double polygon_area = 0.0;
    for (const MeshTriangle& triangle : mesh.triangles) {
        const Vec3& a = mesh.positions[triangle.vertices[0]];
        const Vec3& b = mesh.positions[triangle.vertices[1]];
        const Vec3& c = mesh.positions[triangle.vertices[2]];
        const Vec3 cross = glm::cross(b - a, c - a);
        const Vec3 middle = (a + b + c) / 3.0;
        if (middle.x > 15.0) {
            inward_volume += glm::dot(a - Vec3(20, 0, 0), cross) / 6.0;
        } else if (middle.x > 5.0) {
            sphere_volume += glm::dot(a - Vec3(10, 0, 0), cross) / 6.0;
            // Nowhere farther from the sphere than the tolerance, middle and edges included.
            for (const Vec3& p : {middle, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0}) {
                EXPECT_GT(glm::length(p - Vec3(10, 0, 0)), 2.0 - 0.01);
            }
        } else if (a.z == 5.0) {
            polygon_area += 0.5 * cross.z;
        } else {
            cylinder_area += 0.5 * glm::length(cross);
            EXPECT_GT(glm::dot(cross, Vec3(middle.x, 0, middle.z)), 0.0);  // outwards
        }
    }
    const double pi = std::numbers::pi;
    EXPECT_NEAR(sphere_volume, 32.0 / 3.0 * pi, 0.01 * 33.5);
    EXPECT_NEAR(inward_volume, -sphere_volume, 1e-9);
    EXPECT_NEAR(cylinder_area, 6.0 * pi, 0.01 * 18.8);
    EXPECT_DOUBLE_EQ(polygon_area, 3.0);
    EXPECT_THROW(nff_mesh(scene, {.tolerance = 1e-12, .limits = {}}, "m.nff"), IoError);
}

TEST_F(MeshFileTest, NffScenes) {
    const auto path = test::data_file("spd/tree.nff");
    if (!path) GTEST_SKIP() << "no spd in the scene data";
    MeshFile file;
    file.format = MeshFormat::kNff;
    file.path = *path;
    file.resolution = 64;
    file.z_up = true;
    const TriangleMesh mesh = load_mesh(file);
    EXPECT_EQ(mesh.materials.size(), 2u);
    // 4,095 spheres and 4,095 cones of at least eight sides, and the ground.
    EXPECT_GE(mesh.triangles.size(), 4095u * (2 * 8 * 3 + 8) + 2);
    EXPECT_GT(mesh_voxel_size_m(file, mesh), 0.0);
}

// A wall of 8 × 4 m without thickness, lit by itself: 9 × 5 voxels of 1 m in one layer.
TEST_F(MeshFileTest, ASceneOfAMeshIsItsVoxelsAlsoOutOfTheCache) {
    write("m.mtl", "newmtl lamp\nKd 0.5 0.25 1\nKe 2 4 8\n");
    write("m.obj", "mtllib m.mtl\nv 0 0 3\nv 8 0 3\nv 8 4 3\nv 0 4 3\nusemtl lamp\nf 1 2 3 4\n");
    const SceneFile file =
        scene(R"("type": "obj", "file": "m.obj", "voxel_size_m": 1, "emission_scale": 10)");
    EXPECT_TRUE(is_foreign(file));
    const std::filesystem::path cache = folder_ / "cache";
    import_scene(file, cache);
    const std::optional<Scene> cached = find_cached_scene(file, cache);
    ASSERT_TRUE(cached);
    const Scene loaded = load_scene(file);
    for (const Scene* world : {&*cached, &loaded}) {
        EXPECT_EQ(world->tree.voxel_count(), 45U);
        EXPECT_EQ(world->corner_m, Vec3(-0.5, -0.5, 2.5));
        ASSERT_TRUE(world->mesh);
        EXPECT_EQ(world->mesh->voxels.triangles, 2U);
        EXPECT_EQ(world->mesh->voxels.uncovered_points, 0U);
        EXPECT_LE(world->mesh->voxels.hausdorff_m, world->mesh->voxels.voxel_diagonal_m);
        EXPECT_TRUE(world->emits());
        EXPECT_TRUE(world->inside_voxel({4.0, 2.0, 3.0}));
        EXPECT_FALSE(world->inside_voxel({4.0, 2.0, 4.0}));
    }
    EXPECT_TRUE(loaded.tree == cached->tree);
}

}  // namespace
}  // namespace probebake
