#include "scene/generators/generators.h"

#include <algorithm>
#include <array>
#include <bit>
#include <stdexcept>

#include "scene/generators/cornell.h"
#include "scene/generators/landscape.h"
#include "scene/generators/studies.h"

namespace probebake {
namespace {

using worldgen::Landscape;

template <Landscape (*make)(uint64_t)>
VoxelCloud landscape(int size, uint64_t seed) {
    return worldgen::voxelize(make(seed), size, seed);
}

struct Generator {
    GeneratorInfo info;
    VoxelCloud (*make)(int size, uint64_t seed);
    bool study;  // voxels of a fixed edge, not a world of a fixed side
};

constexpr int kMaxLandscape = 8192;
constexpr int kMaxStudy = 4096;

using namespace worldgen;  // the makers below
constexpr std::array<Generator, 15> kGenerators = {{
    {{"desert", "sandstone plateau, canyon with a walled town, dunes, a dark wood", 64,
      kMaxLandscape},
     landscape<make_desert>,
     false},
    {{"forest", "river valley under dense mixed woods, rock walls, snow on the heights", 64,
      kMaxLandscape},
     landscape<make_forest>,
     false},
    {{"mountain", "snow-covered ridges and conifers, a frozen lake", 64, kMaxLandscape},
     landscape<make_mountain>,
     false},
    {{"biomes", "forest, snowy mountain, desert and snow-covered desert around a lake", 64,
      kMaxLandscape},
     landscape<make_biomes>,
     false},
    {{"grating", "one-voxel bars of several periods and orientations over flat ground", 64,
      kMaxStudy},
     make_grating,
     true},
    {{"net", "a sagging net of one-voxel ropes over boxes and balls", 64, kMaxStudy},
     make_net,
     true},
    {{"canopy", "three layers of scattered leaves over flat ground", 64, kMaxStudy},
     make_canopy,
     true},
    {{"cornell", "a 32-voxel box, a light behind a one-voxel grating, its beam on a floor",
      cornell::kMinWorld, kMaxStudy},
     make_cornell,
     true},
    {{"slackline", "a one-voxel line between two trees, and wires", 128, kMaxStudy},
     make_slackline,
     true},
    {{"torch", "one strongly emissive voxel on a wall", 32, kMaxStudy}, make_torch, true},
    {{"sphere", "a hollow ball", 16, kMaxStudy}, make_sphere, true},
    {{"box", "a hollow cube", 16, kMaxStudy}, make_box, true},
    {{"plane", "one layer of voxels", 16, kMaxStudy}, make_plane, true},
    {{"stairs", "sixteen steps", 32, kMaxStudy}, make_stairs, true},
    {{"single", "one voxel", 16, kMaxStudy}, make_single, true},
}};

constexpr auto kInfos = [] {
    std::array<GeneratorInfo, kGenerators.size()> infos{};
    for (size_t i = 0; i < infos.size(); ++i) infos[i] = kGenerators[i].info;
    return infos;
}();

const Generator& checked(const GeneratorParams& params) {
    const auto* found =
        std::find_if(kGenerators.begin(), kGenerators.end(),
                     [&](const Generator& g) { return g.info.name == params.name; });
    if (found == kGenerators.end()) {
        std::string names;
        for (const GeneratorInfo& info : kInfos) {
            names += (names.empty() ? "" : ", ") + std::string(info.name);
        }
        throw std::invalid_argument("no generator is named '" + params.name +
                                    "'; expected one of " + names);
    }
    const GeneratorInfo& info = found->info;
    if (params.size < info.min_size || params.size > info.max_size ||
        !std::has_single_bit(static_cast<unsigned>(params.size))) {
        throw std::invalid_argument(
            "the size of a '" + params.name + "' world is a power of two from " +
            std::to_string(info.min_size) + " to " + std::to_string(info.max_size) +
            " voxels, not " + std::to_string(params.size));
    }
    return *found;
}

}  // namespace

std::span<const GeneratorInfo> generators() { return kInfos; }

VoxelCloud generate(const GeneratorParams& params) {
    return checked(params).make(params.size, params.seed);
}

double voxel_size_m(const GeneratorParams& params) {
    return checked(params).study ? kStudyVoxel_m : kWorldSide_m / params.size;
}

}  // namespace probebake
