// The large world of real maps against its known answers.
#include "scene/vox_facts.h"

namespace probebake {
namespace {

TEST(VoxWorld, WorldA) {
    test::expect_facts({.name = "worldA_2048",
                        .distinct_positions = 17'605'736,
                        .lowest = {-1001, -1023, 0},
                        .extent = {2004, 2045, 253},
                        .hash = 0x0FA4'0EE3'7055'4744,
                        .models = 8,
                        .instances = 64,
                        .rotated = 48,
                        .emissive = 89'416});
}

}  // namespace
}  // namespace probebake
