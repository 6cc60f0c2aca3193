// Real .vox files of every kind at hand against their known answers.
#include "scene/vox_facts.h"

namespace probebake {
namespace {

TEST(VoxData, BambooValley) {
    test::expect_facts({.name = "bamboo_valley_iv",
                        .distinct_positions = 585'366,
                        .lowest = {-84, -95, 0},
                        .extent = {168, 190, 244},
                        .hash = 0x5411'A4FF'17EF'85BF,
                        .models = 1,
                        .instances = 1,
                        .rotated = 0,
                        .emissive = 90});
}

TEST(VoxData, AboveTheClouds) {
    test::expect_facts({.name = "above_the_clouds",
                        .distinct_positions = 271'325,
                        .lowest = {-88, -88, 0},
                        .extent = {177, 177, 89},
                        .hash = 0xB1C5'992E'85D7'FF48,
                        .models = 1,
                        .instances = 1,
                        .rotated = 0,
                        .emissive = 5'725});
}

TEST(VoxData, ResearchBaseAssets) {
    test::expect_facts({.name = "research_base_assets",
                        .distinct_positions = 776'613,
                        .lowest = {-243, 358, 0},
                        .extent = {687, 256, 79},
                        .hash = 0x8AC4'2E86'02FF'98AB,
                        .models = 20,
                        .instances = 20,
                        .rotated = 2,
                        .emissive = 25});
}

TEST(VoxData, MultipleModelScene) {
    test::expect_facts({.name = "test_multiple_model_scene",
                        .distinct_positions = 12'926,
                        .lowest = {23, -14, 6},
                        .extent = {106, 106, 16},
                        .hash = 0x6D81'45F3'CA9D'1196,
                        .models = 41,
                        .instances = 104,
                        .rotated = 87,
                        .emissive = 0});
}

}  // namespace
}  // namespace probebake
