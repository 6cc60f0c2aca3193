#include "scatter/tracker_pilot.h"

#include "scatter/scatter_fixture.h"

namespace probebake {
namespace {

using test::World;

Ray ray_into_cloud(RandomStream& random) {
    const Vec3 d = test::random_direction(random);
    return {Vec3(random.uniform(), random.uniform(), random.uniform()) * 4.0 - 2.0 - d * 20.0, d};
}

World world_with(const MediumSpec& spec) {
    World world;
    world.media = Media({spec}, {.max_depth = 5, .threshold = 0.2});
    world.lighting.sky = Sky(SkyGradient{Rgb(1.0f), Rgb(2.0f), Rgb(0.1f)});
    return world;
}

TEST(TrackerPilot, DecidesByVarianceTimesCount) {
    const World world = world_with({.name = "stiff",
                                    .absorption_per_m = Rgb(0.01f, 0.1f, 1.0f),
                                    .scattering_per_m = Rgb(0.1f, 1.0f, 10.0f),
                                    .shape = test::noise_cloud()});
    const TrackerPilot pilot = choose_by_pilot(world.scene(), ray_into_cloud);
    ASSERT_EQ(pilot.rows.size(), 3u);
    EXPECT_EQ(pilot.rows[0].tracker, TrackerKind::kSpectralMis);
    double best = 1e300;
    for (const PilotRow& row : pilot.rows) best = std::min(best, row.product());
    for (const PilotRow& row : pilot.rows) {
        if (row.tracker == pilot.choice.tracker) {
            EXPECT_LE(row.product(), kWorthwhile * best);
        }
    }
    EXPECT_EQ(pilot.count.paths, 6000u);
    EXPECT_EQ(choose_by_pilot(world.scene(), ray_into_cloud).choice.tracker, pilot.choice.tracker);
}

TEST(TrackerPilot, AForcedTrackerIsNotQuestioned) {
    const World world = world_with(
        {.name = "cloud", .scattering_per_m = Rgb(1, 2, 3), .shape = test::noise_cloud()});
    PilotParams params;
    params.choice.forced = TrackerKind::kSpectralMax;
    const TrackerPilot pilot = choose_by_pilot(world.scene(), ray_into_cloud, params);
    EXPECT_EQ(pilot.choice.tracker, TrackerKind::kSpectralMax);
    EXPECT_TRUE(pilot.rows.empty());
}

TEST(DepthPilot, CostlyLookUpsAskForDeeperOctrees) {
    const std::vector<MediumSpec> specs = {
        {.name = "cloud", .scattering_per_m = Rgb(3.0f), .shape = test::noise_cloud()}};
    const World world = world_with(specs[0]);
    const auto depth = [&](double lookup_cost) {
        PilotParams params{.paths = 500};
        params.choice.lookup_cost = lookup_cost;
        const DepthPilot pilot = choose_depth(world.scene(), specs, 0.01, ray_into_cloud, params);
        EXPECT_FALSE(pilot.costs.empty());
        for (const auto& [d, cost] : pilot.costs) EXPECT_GT(cost, 0.0) << d;
        return pilot.max_depth;
    };
    EXPECT_LE(depth(0.1), depth(100.0));
    EXPECT_GT(depth(100.0), 2);
}

}  // namespace
}  // namespace probebake
