// The atlases of RTXGI: tiles by analysis and by brute force, their places, their requests.
#include "bake/ddgi.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "bake/probe_view.h"
#include "image/cubemaps.h"
#include "image/octahedral.h"
#include "voxels/trace.h"

namespace probebake {
namespace {

Cubemap constant(int n, const Rgb& value) {
    return test::make_cubemap(n, [&](const CubePixel&) { return value; });
}

/// Calls check(texel, direction) for the inside of a tile.
template <class Check>
void for_each_texel(const Image& tile, const Check& check) {
    const int inside_px = tile.width() - 2;
    for (int y = 0; y < inside_px; ++y) {
        for (int x = 0; x < inside_px; ++x) {
            check(Vec3(tile.at(x + 1, y + 1)), octahedral_texel_direction(x, y, inside_px));
        }
    }
}

TEST(DdgiTile, ConstantsAreExact) {
    for (const int n : {1, 2, 4, 16, 64, 512}) {
        const DdgiTile tile =
            ddgi_tile(constant(n, Rgb(1.0f, 1e6f, 0.0f)), constant(n, Rgb(2.5f, 6.25f, 0.0f)));
        ASSERT_EQ(tile.irradiance.width(), 8);
        ASSERT_EQ(tile.distance.width(), 16);
        for (const Rgb& texel : tile.irradiance.pixels()) {  // the border, too
            EXPECT_FLOAT_EQ(texel.r, 0.5f) << n;
            EXPECT_FLOAT_EQ(texel.g, 0.5e6f) << n;
            EXPECT_EQ(texel.b, 0.0f) << n;
        }
        for (const Rgb& texel : tile.distance.pixels()) {
            EXPECT_FLOAT_EQ(texel.r, 2.5f) << n;
            EXPECT_FLOAT_EQ(texel.g, 6.25f) << n;
        }
    }
}

// E of 0.5 + 0.5 d is π (1/2 + n/3); RTXGI keeps E / 2π. The lobe of cos^50 leaves 51/52.
TEST(DdgiTile, LinearRadianceIsWhatTheIntegralSays) {
    for (const auto& [n, tolerance] : {std::pair{16, 4e-3}, std::pair{64, 1e-3}}) {
        const Cubemap cube = test::direction_cubemap(n);
        const DdgiTile tile = ddgi_tile(cube, cube);
        double largest = 0.0;
        for_each_texel(tile.irradiance, [&](const Vec3& texel, const Vec3& d) {
            largest = std::max(largest, glm::length(texel - (0.25 + d / 6.0)));
        });
        for_each_texel(tile.distance, [&](const Vec3& texel, const Vec3& d) {
            largest = std::max(largest, glm::length(texel - (0.5 + 51.0 / 104.0 * d)));
        });
        std::printf("N = %d: off by %.1e at most\n", n, largest);
        EXPECT_LT(largest, tolerance) << n;
    }
}

TEST(DdgiAtlas, PlanesOfTheVerticalAxisLieSideBySide) {
    const IVec3 counts(2, 3, 4);
    std::vector<DdgiTile> tiles(24);
    std::vector<const DdgiTile*> pointers;
    for (size_t p = 0; p < tiles.size(); ++p) {
        const auto value = static_cast<float>(p);
        tiles[p] = {Image(8, 8), Image(16, 16)};
        for (Rgb& texel : tiles[p].irradiance.pixels()) texel = Rgb(value);
        for (Rgb& texel : tiles[p].distance.pixels()) texel = Rgb(value);
        tiles[p].irradiance.at(7, 0) = Rgb(100.0f);
        pointers.push_back(&tiles[p]);
    }
    const DdgiAtlas atlas = ddgi_atlas(counts, pointers);
    ASSERT_EQ(atlas.irradiance.width(), 2 * 3 * 8);
    ASSERT_EQ(atlas.irradiance.height(), 4 * 8);
    ASSERT_EQ(atlas.distance.width(), 2 * 3 * 16);
    ASSERT_EQ(atlas.distance.height(), 4 * 16);
    for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < 3; ++j) {
            for (int i = 0; i < 2; ++i) {
                const auto probe = static_cast<float>(i + 2 * (j + 3 * k));
                const int column = i + j * 2;
                EXPECT_EQ(atlas.irradiance.at(8 * column, 8 * k + 7).r, probe);
                EXPECT_EQ(atlas.irradiance.at(8 * column + 7, 8 * k).r, 100.0f);
                EXPECT_EQ(atlas.distance.at(16 * column + 15, 16 * k).r, probe);
            }
        }
    }
}

Json grid_request(const Json& counts = {2, 1, 2}, int face_size_px = 32) {
    Json request = test::small_request(1, {{"rays", 2'000'000}});
    request["face_size_px"] = face_size_px;
    const Vec3 p = test::small_scene().to_metres(test::kSmallWorldProbe);
    request["probes"] = {{"grids",
                          {{{"id", "g"},
                            {"origin_m", {p.x, p.y, p.z}},
                            {"spacing_m", {1.0, 0.5, 1.5}},
                            {"counts", counts}}}}};
    request["products"] = {"ddgi"};
    return request;
}

std::string problem_of(const Json& request) {
    try {
        read_job(request);
    } catch (const SpecError& error) {
        return error.issues().at(0).pointer + ": " + error.issues().at(0).detail;
    }
    return "none";
}

TEST(DdgiRequest, IsOfGridsAlone) {
    EXPECT_EQ(problem_of(grid_request()), "none");
    const auto begins = [](const Json& request, const std::string& expected) {
        EXPECT_EQ(problem_of(request).substr(0, expected.size()), expected);
    };
    Json list = test::small_request(2);
    list["products"] = {"cube", "ddgi"};
    begins(list, "/probes/list: the product \"ddgi\" is an atlas of a grid");
    Json both = grid_request();
    both["probes"]["list"] = list["probes"]["list"];
    begins(both, "/probes/list: the product \"ddgi\" is an atlas of a grid");
    Json flat = grid_request();
    flat["probes"]["grids"][0]["spacing_m"][1] = 0;
    begins(flat, "/probes/grids/0/spacing_m/1: the product \"ddgi\" expects more than 0");
    begins(grid_request({1025, 1, 1}, 1), "/probes/grids/0/counts: the atlas of distances");
    EXPECT_EQ(problem_of(grid_request({1024, 1, 1}, 1)), "none");
    Json shared = grid_request();
    shared["probes"]["grids"].push_back(shared["probes"]["grids"][0]);
    shared["probes"]["grids"][1]["id"] = "g-0-0-1";
    begins(shared, "/probes/grids/1/id: is the id of a probe, too");
    // Without the atlas nothing of this matters.
    for (Json& request : std::vector<Json>{list, both, flat, shared}) {
        request["products"] = {"cube"};
        EXPECT_EQ(problem_of(request), "none");
    }
}

TEST(DdgiRequest, TheEffectiveRequestKeepsTheGrid) {
    const JobSpec job = read_job(grid_request({2, 3, 4}));
    ASSERT_EQ(job.grids.size(), 1U);
    EXPECT_EQ(job.grids[0].size(), 24U);
    EXPECT_EQ(grid_of(job, 23), &job.grids[0]);
    const Json written = write_job(job);
    EXPECT_EQ(written["probes"]["grids"][0]["counts"], Json({2, 3, 4}));
    EXPECT_EQ(write_job(read_job(written)), written);
    EXPECT_EQ(read_job(written).probes[23].position_m, job.probes[23].position_m);
    EXPECT_NEAR(ddgi_max_distance_m(job.grids[0]), 1.5 * std::sqrt(3.5), 1e-12);
}

class DdgiBakeTest : public testing::Test {
  protected:
    ProbeResult bake(const JobSpec& job) const {
        const Pilot pilot =
            run_pilot(scene_, job, make_plan(scene_, job), LightingState::kAlbedo, cancel_);
        return bake_probe(scene_, job, pilot, {.probe = 0}, cancel_);
    }

    Scene scene_ = test::small_scene();
    CancelToken cancel_;
};

// Against rays from the probe: 2¹⁶ directions spread evenly over the sphere (Fibonacci), whose own
// noise is some 0.5 %, leaf voxels, every distance cut off by itself.
TEST_F(DdgiBakeTest, IsWithinItsErrorOfRaysFromTheProbe) {
    Json request = grid_request({1, 1, 1}, 64);
    request["quality"] = {{"renderer", "reference"},
                          {"settings", {{"leaf_grid", 4}}},
                          {"evidence", {{"audit", false}}}};
    for (const double spacing_m : {1.0, 4.0}) {
        for (Json& axis : request["probes"]["grids"][0]["spacing_m"]) axis = spacing_m;
        const JobSpec job = read_job(request);
        const ProbeResult result = bake(job);
        EXPECT_TRUE(result.files.empty());
        ASSERT_TRUE(result.ddgi);
        const double farthest_m = ddgi_max_distance_m(job.grids[0]);
        const RenderScene what = render_scene(scene_, job.probes[0], LightingState::kAlbedo);
        const Vec3 origin = scene_.to_voxels(job.probes[0].position_m);
        constexpr int kRays = 1 << 16;
        std::vector<Vec3> directions;
        std::vector<Vec3> radiance;
        std::vector<double> distances_m;
        for (int i = 0; i < kRays; ++i) {
            const double z = 1.0 - (2.0 * i + 1.0) / kRays;
            const double phi = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
            const double r = std::sqrt(1.0 - z * z);
            const Vec3 d(r * std::cos(phi), r * std::sin(phi), z);
            Hit hit = trace(what.tree, {origin, d}, {}, what.range);
            directions.push_back(d);
            distances_m.push_back(std::min(hit.t * scene_.voxel_size_m, farthest_m));
            radiance.emplace_back(shade(what, d, hit));
        }
        double irradiance_error = 0.0;
        for_each_texel(result.ddgi->irradiance, [&](const Vec3& texel, const Vec3& n) {
            Vec3 sum(0.0);
            for (int i = 0; i < kRays; ++i) {
                const auto ray = static_cast<size_t>(i);
                sum += radiance[ray] * std::max(0.0, glm::dot(directions[ray], n));
            }
            // E / 2π = Σ L cos · (4π / rays) / 2π
            const Vec3 exact = 2.0 * sum / static_cast<double>(kRays);
            const Vec3 error = glm::abs(texel / exact - 1.0);
            irradiance_error = std::max({irradiance_error, error.r, error.g, error.b});
        });
        double distance_error = 0.0;
        for_each_texel(result.ddgi->distance, [&](const Vec3& texel, const Vec3& n) {
            double sum = 0.0;
            double square = 0.0;
            double weights = 0.0;
            for (int i = 0; i < kRays; ++i) {
                const auto ray = static_cast<size_t>(i);
                const double cosine = glm::dot(directions[ray], n);
                if (cosine < 0.7) continue;  // cos^50 is below 2e-8
                const double w = std::pow(cosine, 50.0);
                sum += w * distances_m[ray];
                square += w * distances_m[ray] * distances_m[ray];
                weights += w;
            }
            distance_error = std::max({distance_error, std::abs(texel.r * weights / sum - 1.0),
                                       std::abs(std::sqrt(texel.g * weights / square) - 1.0)});
            EXPECT_LE(texel.r, farthest_m * (1.0 + 1e-6));
            EXPECT_GE(texel.g, texel.r * texel.r * (1.0 - 1e-6));
        });
        std::printf("spacing %.0f m: irradiance off by %.1e, distances by %.1e at most\n",
                    spacing_m, irradiance_error, distance_error);
        EXPECT_LT(irradiance_error, 0.01);
        EXPECT_LT(distance_error, 0.02);
    }
}

// A cube is the same whether an atlas is made of it or not, and aux keeps its uncut distances.
TEST_F(DdgiBakeTest, OtherProductsDoNotNotice) {
    Json request = grid_request({1, 1, 1}, 16);
    request["products"] = {"cube", "aux", "ddgi"};
    const ProbeResult with = bake(read_job(request));
    request["products"] = {"cube", "aux"};
    const ProbeResult without = bake(read_job(request));
    ASSERT_EQ(with.files.size(), 2U);
    for (size_t i = 0; i < 2; ++i) EXPECT_EQ(with.files[i].sha256, without.files[i].sha256);
    EXPECT_FALSE(without.ddgi);
}

}  // namespace
}  // namespace probebake
