#include "scene/nff/nff_file.h"

#include <gtest/gtest.h>

#include <array>

#include "io/io_error.h"
#include "math/random.h"
#include "support/data.h"

namespace probebake {
namespace {

const std::string kView =
    "v\nfrom 1 2 3\nat 0 0 0\nup 0 0 1\nangle 45\nhither 0.5\nresolution 512 256\n";
const std::string kHead = kView + "f 1 0.5 0.25 0.75 0.5 3 0.125 1.5\n";

TEST(Nff, EveryStatementIsRead) {
    const NffScene scene = parse_nff("# a comment, \"p 3\" and all\nb 0.25 0.5 1 # sky\n" + kView +
                                         "l 1 2 3\nl 4 5 6 0.5 0.25 1\n"
                                         "f 1 0.5 0.25 0.75 0.5 3 0.125 1.5\n"
                                         "s 1 2 3 0.5\n"
                                         "s 1 2 3 -0.5\n"
                                         "c\n0 0 0 2\n0 0 4 1\n"
                                         "f 0 0 0 1 0 100000 0 0\n"
                                         "c 0 0 0 -1 0 0 4 -1\n"
                                         "p 3\n0 0 0\n1 0 0\n0 1 0\n"
                                         "p 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
                                         "pp 3\n0 0 0 0 0 1\n1 0 0 0 1 0\n0 1 0 1 0 0\n",
                                     "all.nff");
    ASSERT_TRUE(scene.view);
    EXPECT_EQ(scene.view->from, Vec3(1.0, 2.0, 3.0));
    EXPECT_EQ(scene.view->at, Vec3(0.0));
    EXPECT_EQ(scene.view->up, Vec3(0.0, 0.0, 1.0));
    EXPECT_EQ(scene.view->angle_deg, 45.0);
    EXPECT_EQ(scene.view->hither, 0.5);
    EXPECT_EQ(scene.view->width_px, 512);
    EXPECT_EQ(scene.view->height_px, 256);
    EXPECT_EQ(scene.background, Rgb(0.25f, 0.5f, 1.0f));
    ASSERT_EQ(scene.lights.size(), 2u);
    EXPECT_EQ(scene.lights[0].position, Vec3(1.0, 2.0, 3.0));
    EXPECT_FALSE(scene.lights[0].color);
    EXPECT_EQ(scene.lights[1].color, Rgb(0.5f, 0.25f, 1.0f));
    ASSERT_EQ(scene.materials.size(), 2u);
    EXPECT_EQ(scene.materials[0].color, Rgb(1.0f, 0.5f, 0.25f));
    EXPECT_EQ(scene.materials[0].diffuse, 0.75);
    EXPECT_EQ(scene.materials[0].specular, 0.5);
    EXPECT_EQ(scene.materials[0].shine, 3.0);
    EXPECT_EQ(scene.materials[0].transmittance, 0.125);
    EXPECT_EQ(scene.materials[0].refraction_index, 1.5);

    ASSERT_EQ(scene.shapes.size(), 7u);
    ASSERT_EQ(scene.objects.size(), 7u);
    EXPECT_EQ(scene.shapes.spheres().size(), 2u);
    EXPECT_EQ(scene.shapes.cones().size(), 2u);
    EXPECT_EQ(scene.shapes.triangles().size(), 2u);
    EXPECT_EQ(scene.shapes.polygons().size(), 1u);
    EXPECT_EQ(scene.shapes.spheres()[0].center, Vec3(1.0, 2.0, 3.0));
    EXPECT_EQ(scene.shapes.spheres()[1].radius, 0.5);
    EXPECT_FALSE(scene.objects[0].inward);
    EXPECT_TRUE(scene.objects[1].inward);
    EXPECT_EQ(scene.shapes.cones()[0].base_radius, 2.0);
    EXPECT_EQ(scene.shapes.cones()[0].apex, Vec3(0.0, 0.0, 4.0));
    EXPECT_EQ(scene.shapes.cones()[1].apex_radius, 1.0);
    EXPECT_TRUE(scene.objects[3].inward);
    EXPECT_EQ(scene.objects[2].material, 0u);
    EXPECT_EQ(scene.objects[3].material, 1u);
    EXPECT_EQ(scene.shapes.triangles()[1].b, Vec3(1.0, 0.0, 0.0));
    ASSERT_EQ(scene.objects[6].first_normal, 0u);
    ASSERT_EQ(scene.normals.size(), 3u);
    EXPECT_EQ(scene.normals[1], Vec3(0.0, 1.0, 0.0));
    EXPECT_FALSE(scene.objects[5].first_normal);
}

TEST(Nff, AnyWhiteSpaceAndAnyOrderInTheView) {
    const NffScene scene = parse_nff(
        "v\r\nresolution 8 8 hither 1 angle 30\r\nup 0 1 0\tfrom 1 1 1 at 0 0 0\r\n"
        "f 1 1 1 1 0 1 0 0 s 1e0 -2.5E-1 .5 1#end",
        "a.nff");
    EXPECT_EQ(scene.view->angle_deg, 30.0);
    EXPECT_EQ(scene.shapes.spheres()[0].center, Vec3(1.0, -0.25, 0.5));
    EXPECT_EQ(parse_nff("", "empty.nff").shapes.size(), 0u);
}

struct Refused {
    std::string text;
    const char* message;
};

TEST(Nff, DamageIsRefusedWithLineAndWhatWasExpected) {
    const Refused cases[] = {
        {"x 1", "a.nff: line 1: expected a statement: v, b, l, f, c, s, p or pp, not \"x\""},
        {"b 1 2",
         "a.nff: line 1: expected red, green and blue of the background, a finite number, not the "
         "end of the file"},
        {kHead + "s 1 2 oops 1",
         "a.nff: line 9: expected x, y, z of a sphere's centre, a finite number, not \"oops\""},
        {kHead + "s 1 2 nan 1", "line 9: expected x, y, z of a sphere's centre, a finite number"},
        {kHead + "s 1 2 1e999 1", "line 9: expected x, y, z of a sphere's centre, a finite number"},
        {kHead + "s 1 2 3x 1", "line 9: expected x, y, z of a sphere's centre"},
        {kHead + "s 1 2 3\ns 4 5 6 1",
         "line 10: expected a sphere's radius, a finite number, not \"s\""},
        {kHead + "p 2\n0 0 0\n1 0 0",
         "line 9: expected a polygon's number of vertices, a whole number from 3 on, not \"2\""},
        {kHead + "p 3.5", "a whole number from 3 on, not \"3.5\""},
        {kHead + "p 99999999999", "a whole number from 3 on, not \"99999999999\""},
        {kHead + "p 2000000000\n0 0 0\n",
         "line 11: expected x, y, z of a vertex, a finite number, not the end of the file"},
        {kHead + "pp 3\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0\n",
         "line 13: expected x, y, z of a normal"},
        {kHead + "c\n0 0 0 1\n0 0 0 1", "line 9: cone: expected two ends that differ"},
        {kHead + "c\n0 0 0 1\n0 0 1 -1", "line 9: cone: expected two radii of one sign"},
        {kHead + kView, "line 9: expected one view, not a second"},
        {kHead + "s 0 0 0 1\nl 0 0 1", "line 10: expected lights before the first object"},
        {"f 1 1 1 1 0 1 0 0\ns 0 0 0 1\n" + kView, "line 3: expected the view before the first"},
        {"s 0 0 0 1", "line 1: expected a material (f) before the first object"},
        {"v\nfrom 0 0 0\nfrom 1 1 1",
         "line 3: expected of the view: at, up, angle, hither, resolution"},
        {"v\nfrom 0 0 0\nresolution 0 5", "line 3: expected the width in pixels, a whole number"},
        {"b 1e39 0 0", "line 1: red, green and blue of the background: too large a number"},
        {"\x01\x02", "line 1: expected a statement: v, b, l, f, c, s, p or pp, not \"\?\?\""},
    };
    for (const Refused& refused : cases) {
        try {
            parse_nff(refused.text, "a.nff");
            FAIL() << refused.text;
        } catch (const IoError& error) {
            EXPECT_NE(std::string(error.what()).find(refused.message), std::string::npos)
                << error.what();
        }
    }
}

TEST(Nff, EveryTruncationAndEveryFlippedByteIsASceneOrAnError) {
    const std::string text = kHead + "s 1 2 3 0.5\nc 0 0 0 1 0 0 4 1\np 3\n0 0 0\n1 0 0\n0 1 0\n";
    int refused = 0;
    const auto parse = [&](const std::string& damaged) {
        try {
            const NffScene scene = parse_nff(damaged, "damaged.nff");
            EXPECT_EQ(scene.objects.size(), scene.shapes.size());
        } catch (const IoError& error) {
            EXPECT_NE(std::string(error.what()).find("line "), std::string::npos);
            ++refused;
        }
    };
    for (size_t length = 0; length < text.size(); ++length) parse(text.substr(0, length));
    for (size_t i = 0; i < text.size(); ++i) {
        for (int bit = 0; bit < 8; ++bit) {
            std::string damaged = text;
            damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
            parse(damaged);
        }
    }
    EXPECT_GT(refused, 500);
}

struct SpdScene {
    const char* file;
    size_t spheres;
    size_t cones;
    size_t flat;  // polygons and triangles
    size_t lights;
};

TEST(NffData, TheDatabasesHaveTheirNumbersOfObjects) {
    constexpr std::array<SpdScene, 8> kScenes = {{{"balls", 7381, 0, 1, 3},
                                                  {"gears", 0, 0, 9345, 5},
                                                  {"lattice", 2197, 6084, 0, 6},
                                                  {"mount", 4, 0, 8192, 1},
                                                  {"rings", 4200, 4200, 1, 3},
                                                  {"teapot_s12", 0, 0, 9264, 2},
                                                  {"tetra", 0, 0, 4096, 1},
                                                  {"tree", 4095, 4095, 1, 7}}};
    for (const SpdScene& spd : kScenes) {
        const auto path = test::data_file("spd/" + std::string(spd.file) + ".nff");
        if (!path) GTEST_SKIP() << "no spd/" << spd.file << ".nff in PROBEBAKE_DATA";
        const NffScene scene = read_nff(*path);
        EXPECT_EQ(scene.shapes.spheres().size(), spd.spheres) << spd.file;
        EXPECT_EQ(scene.shapes.cones().size(), spd.cones) << spd.file;
        EXPECT_EQ(scene.shapes.polygons().size() + scene.shapes.triangles().size(), spd.flat)
            << spd.file;
        EXPECT_EQ(scene.lights.size(), spd.lights) << spd.file;
        ASSERT_TRUE(scene.view) << spd.file;
        EXPECT_EQ(scene.view->width_px, 512) << spd.file;
    }
}

TEST(NffData, NormalsOfThePatchesStandByTheirVertices) {
    const auto path = test::data_file("spd/teapot_s12.nff");
    if (!path) GTEST_SKIP() << "no spd/teapot_s12.nff in PROBEBAKE_DATA";
    const NffScene scene = read_nff(*path);
    size_t patches = 0;
    int turned = 0;
    for (uint32_t i = 0; i < scene.objects.size(); ++i) {
        if (!scene.objects[i].first_normal) continue;
        ++patches;
        const Vec3 normal = scene.normals[*scene.objects[i].first_normal];
        EXPECT_NEAR(glm::length(normal), 1.0, 1e-4);
        if (glm::dot(normal, normal_at(scene.shapes, i, Vec3(0.0))) < 0.0) ++turned;
    }
    EXPECT_EQ(patches, 9120u);
    EXPECT_EQ(scene.normals.size(), 3 * patches);
    EXPECT_LT(turned, 100);  // vertices turn counter-clockwise around the normal
}

}  // namespace
}  // namespace probebake
