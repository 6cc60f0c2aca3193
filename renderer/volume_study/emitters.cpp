#include "volume_study/emitters.h"

#include "math/estimate.h"
#include "scatter/tracker_pilot.h"
#include "scene/generators/cumulus.h"
#include "volume/phase.h"
#include "volume_study/cpu_clock.h"

namespace probebake::volume_study {
namespace {

using study::decimals;

struct EmissiveWorld {
    const char* name;
    int depth;          // of its tree; voxels are 1 m
    int lamps;          // single voxels above the ground
    bool glows;         // whether the ground emits
    double sky = 0.05;  // radiance
};

constexpr EmissiveWorld kWorlds[] = {
    {"13 lamps", 7, 13, false},        {"13 lamps by day", 7, 13, false, 5.0},
    {"1,000 lamps", 8, 1000, false},   {"a glowing ground", 6, 0, true},
    {"a million voxels", 10, 0, true}, {"no emissive voxel", 7, 0, false}};

struct Fog {
    const char* name;
    double column;  // optical thickness of the height of 64 m
};
constexpr Fog kFogs[] = {{"thin", 0.5}, {"thick", 10.0}};
constexpr double kHeight = 64.0;

/// Ground with lamps as bright in all as a ground of 64² that glows with radiance 1.
VoxelTree tree_of(const EmissiveWorld& world) {
    VoxelCloud cloud;
    cloud.depth = world.depth;
    const int side = 1 << world.depth;
    const PackedRgb albedo = pack_rgb(Rgb(0.5f));
    for (int z = 0; z < side; ++z) {
        for (int x = 0; x < side; ++x) {
            cloud.voxels.push_back(
                make_voxel({x, 0, z}, albedo, pack_rgb(Rgb(world.glows ? 1.0f : 0.0f))));
        }
    }
    RandomStream random(random_key({1}));
    for (int i = 0; i < world.lamps; ++i) {
        const auto place = [&](int within) {
            return static_cast<int>(random.below(static_cast<uint64_t>(within)));
        };
        const int x = place(side);
        const int y = 2 + place(30);
        const Rgb light(64.0f * 64.0f / 6.0f / static_cast<float>(world.lamps));
        cloud.voxels.push_back(make_voxel({x, y, place(side)}, albedo, pack_rgb(light)));
    }
    return VoxelTree::build(std::move(cloud));
}

struct Measured {
    Moments variance;  // of what is scattered from emitters, within a ray, mean over the channels
    double seconds = 0.0;
};

Measured measure(const PathTracer& tracer, int paths, const PilotRay& ray) {
    Measured out;
    PathCount count;
    const double start = cpu_seconds();
    for (int i = 0; i < paths / 2; ++i) {
        const auto index = static_cast<uint64_t>(i);
        RandomStream for_ray(random_key({71, index}));
        const Ray at = ray(for_ray);
        PathRandom a(random_key({72, index}));
        PathRandom b(random_key({73, index}));
        const Vec3 d =
            tracer.trace(at, {}, a, count).emitted - tracer.trace(at, {}, b, count).emitted;
        out.variance.add(glm::dot(d, d) / 6.0);
    }
    out.seconds = cpu_seconds() - start;
    return out;
}

}  // namespace

study::TextTable emitter_table(int paths, const std::function<void(const std::string&)>& progress) {
    study::TextTable table;
    table.name = "emitters";
    table.title =
        "Rays to emissive voxels, " + std::to_string(paths) +
        " paths per row; variance of their scattered light, cost and time with them over those "
        "without";
    table.columns = {"world",
                     "fog",
                     "emitters",
                     "tree, MB",
                     "variance",
                     "its error",
                     "cost, counted",
                     "variance × cost",
                     "time",
                     "variance × time",
                     "pilot: variance × cost",
                     "pilot takes them"};
    for (const EmissiveWorld& world : kWorlds) {
        const VoxelTree tree = tree_of(world);
        const EmitterSampler emitters(tree);
        const double side = 1 << world.depth;
        for (const Fog& fog : kFogs) {
            progress(std::string("emitters: ") + world.name + ", " + fog.name);
            const Media media(
                {{.name = "fog",
                  .absorption_per_m = Rgb(static_cast<float>(0.02 * fog.column / kHeight)),
                  .scattering_per_m = Rgb(static_cast<float>(0.98 * fog.column / kHeight)),
                  .g = 0.7,
                  .shape = HomogeneousShape{Box{Vec3(0.0), {side, kHeight, side}}}}});
            Lighting lighting;
            lighting.sky = Sky(Rgb(static_cast<float>(world.sky)));
            ScatterScene scene{tree, 1.0, Vec3(0.0), media, lighting};
            const TrackerChoice choice = choose_tracker(facts_of(media));
            const PilotRay ray = [side](RandomStream& random) {
                const double x = random.uniform() * side;
                const double y = 4.0 + 56.0 * random.uniform();
                const double z = random.uniform() * side;
                const double cosine = 2.0 * random.uniform() - 1.0;
                return Ray{{x, y, z}, around({0, 1, 0}, cosine, random.uniform())};
            };
            if (emitters.empty()) {
                table.rows.push_back({world.name, fog.name, "0", "0", "1", "-", "1", "1", "1", "1",
                                      "-", "left out"});
                continue;
            }
            const Measured without = measure(PathTracer(scene, choice), paths, ray);
            scene.emitters = &emitters;
            const Measured with = measure(PathTracer(scene, choice), paths, ray);
            const EmitterPilot pilot = choose_emitters(scene, choice, ray);
            const double variance = with.variance.mean() / without.variance.mean();
            const auto relative = [](const Moments& m) {
                return m.variance() / (static_cast<double>(m.count()) * m.mean() * m.mean());
            };
            const double error =
                variance * std::sqrt(relative(with.variance) + relative(without.variance));
            const double cost = pilot.cost_sampled / pilot.cost_found;
            const double time = with.seconds / without.seconds;
            const double foreseen = pilot.variance_sampled * pilot.cost_sampled /
                                    (pilot.variance_found * pilot.cost_found);
            table.rows.push_back({world.name, fog.name, std::to_string(emitters.size()),
                                  decimals(static_cast<double>(emitters.memory_bytes()) * 1e-6, 2),
                                  decimals(variance, 4), decimals(error, 4), decimals(cost, 2),
                                  decimals(variance * cost, 4), decimals(time, 2),
                                  decimals(variance * time, 4), decimals(foreseen, 4),
                                  pilot.sampled ? "yes" : "no"});
        }
    }
    return table;
}

}  // namespace probebake::volume_study
