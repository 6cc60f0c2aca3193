#include "study/octrees/octree_study.h"

#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

#include "io/file.h"
#include "study/octrees/fluid_scene.h"
#include "study/octrees/octree_figures.h"
#include "study/octrees/spd_rays.h"
#include "support/data.h"

namespace probebake::study {
namespace {

std::filesystem::path test_folder() {
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    return std::filesystem::path(testing::TempDir()) / ("probebake-octrees-" + test);
}

/// A ball and a light behind the eye; the ball's surface as given.
NffScene ball(double specular, double transmittance) {
    NffScene scene;
    scene.view = NffView{.from = {0.0, 0.0, 10.0},
                         .at = {0.0, 0.0, 0.0},
                         .up = {0.0, 1.0, 0.0},
                         .angle_deg = 45.0,
                         .hither = 0.1,
                         .width_px = 512,
                         .height_px = 512};
    scene.lights = {{.position = {0.0, 0.0, 10.0}}};
    scene.materials = {
        {.specular = specular, .transmittance = transmittance, .refraction_index = 1.5}};
    scene.shapes.add(Sphere{Vec3(0.0), 2.0});
    scene.objects = {{}};
    return scene;
}

SpdRayCounts rays_of(const NffScene& scene, const SpdRayParams& params) {
    const ObjectOctree octree(scene.shapes, safe_boxes(scene.shapes), {.max_depth = 4});
    return count_rays(spd_rays(scene, octree, params));
}

TEST(SpdRays, EyeRaysAreAtTheCornersOfPixels) {
    const SpdRayCounts counts = rays_of(ball(0.0, 0.0), {.size_px = 100});
    EXPECT_EQ(counts.cast[0], 101u * 101u);
    // The ball's outline is a circle: sin a = 2/10 seen from the eye, tan 22.5° at the border.
    const double radius_px = std::tan(std::asin(0.2)) / std::tan(std::numbers::pi / 8) * 50.0;
    EXPECT_NEAR(static_cast<double>(counts.used[0]), std::numbers::pi * radius_px * radius_px,
                30.0);
    EXPECT_EQ(counts.cast[1], 0u);
    // The light sits in the eye: every point seen faces it, and nothing is between.
    EXPECT_EQ(counts.cast[2], counts.used[0]);
    EXPECT_EQ(counts.used[2], 0u);
}

TEST(SpdRays, ReflectedAndRefractedRaysGoToDepthFive) {
    const SpdRayParams params{.size_px = 40};
    const SpdRayCounts mirror = rays_of(ball(0.5, 0.0), params);
    EXPECT_EQ(mirror.cast[1], mirror.used[0]);  // one each, into the open
    EXPECT_EQ(mirror.used[1], 0u);
    // Glass: outside one reflected ray, lost, and one refracted; inside every hit gives one that
    // stays inside and one that leaves. Depths 2 to 5: 2 + 2 + 2 + 2 per eye ray.
    const SpdRayCounts glass = rays_of(ball(0.0, 0.9), params);
    EXPECT_EQ(glass.cast[1], 8 * glass.used[0]);
    EXPECT_EQ(glass.used[1], 4 * glass.used[0]);
    const SpdRayCounts shallow = rays_of(ball(0.0, 0.9), {.size_px = 40, .max_depth = 2});
    EXPECT_EQ(shallow.cast[1], 2 * glass.used[0]);
}

TEST(SpdRays, NeedAView) {
    NffScene scene = ball(0.0, 0.0);
    scene.view.reset();
    EXPECT_THROW(rays_of(scene, {}), std::invalid_argument);
}

TEST(FluidStandIn, HasTheNumbersOfTheOriginal) {
    const NffScene scene = fluid_stand_in();
    EXPECT_EQ(scene.shapes.spheres().size(), 2514u);
    EXPECT_EQ(scene.shapes.polygons().size(), 1u);
    EXPECT_EQ(scene.objects.size(), 2515u);
    for (size_t i = 1; i < scene.shapes.spheres().size(); ++i) {
        EXPECT_GE(glm::length(scene.shapes.spheres()[i].center), 0.25);  // none in the ball
    }
    const SpdRayCounts counts = rays_of(scene, {.size_px = 32});
    EXPECT_GT(counts.cast[1], counts.cast[0] / 2);  // many reflected rays
    EXPECT_GT(counts.used[1], 50u);                 // that show the drops
}

TEST(MeasureScene, CountsDoNotDependOnHowOftenOrWhen) {
    const NffScene scene = fluid_stand_in();
    const MeasureParams params{.size_px = 16, .depths = {4, 5}};
    const auto quiet = [](const std::string&) {};
    Json first = measure_scene(scene, params, quiet);
    Json second = measure_scene(scene, params, quiet);
    ASSERT_EQ(first["rows"].size(), 10u);
    EXPECT_EQ(first["disagreements"], 0);
    EXPECT_EQ(first["changed_hits"], 0);
    for (Json* result : {&first, &second}) {
        for (Json& row : (*result)["rows"]) {
            EXPECT_GE(row["trace_seconds"].get<double>(), 0.0);
            row.erase("trace_seconds");
            row.erase("build_seconds");
        }
    }
    EXPECT_EQ(first, second);
    const Json* glassner = find_row(first, "Octree84-C", 5);
    const Json* samet = find_row(first, "Octree89-C", 5);
    const Json* gargantini = find_row(first, "Octree93-C", 5);
    ASSERT_TRUE(glassner != nullptr && samet != nullptr && gargantini != nullptr);
    for (const char* same : {"inner", "references", "tests", "leaves", "empty_leaves"}) {
        EXPECT_EQ(glassner->at(same), samet->at(same)) << same;
        EXPECT_EQ(glassner->at(same), gargantini->at(same)) << same;
    }
    EXPECT_LT(samet->at("steps"), glassner->at("steps"));
    EXPECT_LT(gargantini->at("steps"), samet->at("steps"));
}

class HavranTest : public testing::Test {
  protected:
    void SetUp() override {
        const auto csv = test::data_file("octrees/havran_1999.csv");
        if (!csv) GTEST_SKIP() << "no octrees/havran_1999.csv in PROBEBAKE_DATA";
        tables_ = HavranTables(*csv);
        data_ = csv->parent_path().parent_path();
    }
    std::optional<HavranTables> tables_;
    std::filesystem::path data_;
};

TEST_F(HavranTest, AllValuesAreRead) {
    EXPECT_EQ(tables_->size(), 1800u);
    EXPECT_EQ(tables_->value("Octree84-C", "balls", 7, "N_TS"), 167.0);
    EXPECT_FALSE(tables_->value("Octree84-C", "balls", 8, "N_TS"));
    for (const char* method : kOctreeMethods) {
        for (const char* scene : kOctreeScenes) {
            for (const char* quantity : kOctreeQuantities) {
                EXPECT_TRUE(tables_->value(method, scene, 4, quantity)) << method << scene;
            }
        }
    }
}

TEST_F(HavranTest, TheComparisonTableContradictsTheMethodTablesInElevenColumns) {
    const std::vector<std::string> found = comparison_contradictions(*tables_);
    EXPECT_EQ(found.size(), 11u);
    const auto has = [&](const std::string& sentence) {
        return std::find(found.begin(), found.end(), sentence) != found.end();
    };
    EXPECT_TRUE(has("gears Octree84-A: headed depth 5, values of depth 4"));
    EXPECT_TRUE(has("teapot Octree84-A: repeats Octree84-C"));
    EXPECT_TRUE(has("balls Octree84-A, depth 5: N_B 6.17, in the method's table 0.73"));
}

TEST_F(HavranTest, OneTreeHasTwoCountsOnlyWhereTheDocumentSaysSo) {
    for (const std::string& found : tree_contradictions(*tables_)) {
        EXPECT_TRUE(found.find("-A") != std::string::npos || found.rfind("fluid", 0) == 0) << found;
    }
}

TEST_F(HavranTest, AReducedStudyOfOneSceneIsFoundAgain) {
    OctreeStudyParams params{.out = test_folder(), .data_folder = data_, .scenes = {"tetra"}};
    params.measure = {.size_px = 16, .depths = {4, 5}};
    std::filesystem::remove_all(params.out);
    const auto run = [&] { return run_octree_study(params, [](const StudyProgress&) {}); };
    const OctreeStudyOutcome first = run();
    if (!first.left_out.empty()) GTEST_SKIP() << first.left_out[0];
    EXPECT_EQ(first.computed, 1u);
    const Json& counts = first.summary.at("center_counts");
    EXPECT_EQ(counts.at("count"), 8);
    EXPECT_EQ(counts.at("exact"), 8);
    EXPECT_FALSE(first.summary.contains("steps_off")) << "not comparable at this size";
    const std::vector<std::byte> report = read_file(params.out / "report.md");
    EXPECT_TRUE(std::filesystem::exists(params.out / "tables/Octree89-C.csv"));
    EXPECT_TRUE(std::filesystem::exists(params.out / "octrees.csv"));
    const OctreeStudyOutcome second = run();
    EXPECT_EQ(second.computed, 0u);
    EXPECT_EQ(second.found, 1u);
    EXPECT_EQ(second.results, first.results);
    EXPECT_EQ(read_file(params.out / "report.md"), report);
    std::filesystem::remove_all(params.out);
}

TEST_F(HavranTest, WrongParametersAreRefused) {
    const auto run = [&](const std::vector<std::string>& scenes, const MeasureParams& measure) {
        OctreeStudyParams params{.out = test_folder(), .data_folder = data_, .scenes = scenes};
        params.measure = measure;
        run_octree_study(params, [](const StudyProgress&) {});
    };
    EXPECT_THROW(run({"teapots"}, {}), std::invalid_argument);
    EXPECT_THROW(run({}, {.size_px = 4}), std::invalid_argument);
    EXPECT_THROW(run({}, {.size_px = 1024}), std::invalid_argument);
    EXPECT_THROW(run({}, {.depths = {}}), std::invalid_argument);
    EXPECT_THROW(run({}, {.depths = {3}}), std::invalid_argument);
    EXPECT_THROW(run({}, {.depths = {5, 5}}), std::invalid_argument);
}

TEST(HavranTables, DamageIsRefusedWithItsLine) {
    const std::filesystem::path file = test_folder();
    const auto expect_refused = [&](const std::string& text, const char* where) {
        write_file_atomically(file, text);
        try {
            const HavranTables tables(file);
            FAIL() << text;
        } catch (const IoError& error) {
            EXPECT_NE(std::string(error.what()).find(where), std::string::npos) << error.what();
        }
    };
    const std::string head = "method,scene,maxdepth,quantity,value\n";
    expect_refused("a,b\n", "line 1");
    expect_refused(head + "Octree84-C,balls,4,N_IN\n", "line 2");
    expect_refused(head + "Octree84-C,balls,4,N_IN,57\nOctree84-C,balls,x,N_IN,57\n", "line 3");
    expect_refused(head + "Octree84-C,balls,4,N_IN,nan\n", "line 2");
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace probebake::study
