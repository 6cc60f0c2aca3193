// Paths through test worlds, and their means.
#pragma once

#include <gtest/gtest.h>

#include "light/light_fixture.h"
#include "math/estimate.h"
#include "scatter/path_tracer.h"
#include "support/ray_families.h"
#include "volume/volume_fixture.h"

namespace probebake::test {

/// A cloud of noise over 12³ m at the origin, its edges soft.
inline GridShape noise_cloud(uint64_t seed = 1) {
    Affine map;
    map.linear = glm::dmat3(0.5);
    map.offset = Vec3(-6.0);
    return {std::make_shared<DensityGrid>(noise_grid({0, 0, 0}, {24, 24, 24}, seed)), map, nullptr};
}

struct World {
    VoxelTree tree;
    Media media;
    Lighting lighting;
    double voxel_size_m = 1.0;
    Vec3 corner_m{0.0};

    ScatterScene scene() const { return {tree, voxel_size_m, corner_m, media, lighting}; }
};

struct MeanRadiance {
    std::array<Moments, 3> channels;
    PathCount count;

    double mean(int c) const { return at(c).mean(); }
    double sigma(int c) const {
        return std::sqrt(at(c).variance() / static_cast<double>(at(c).count()));
    }
    const Moments& at(int c) const { return channels[static_cast<size_t>(c)]; }
};

template <class MakeRay>
MeanRadiance mean_radiance(const PathTracer& tracer, int paths, uint64_t seed, MakeRay make_ray,
                           const TRange& range = {}) {
    MeanRadiance out;
    for (int i = 0; i < paths; ++i) {
        PathRandom random(random_key({seed, static_cast<uint64_t>(i)}));
        RandomStream for_ray(random_key({seed, static_cast<uint64_t>(i), 1}));
        const PathResult path = tracer.trace(make_ray(for_ray), range, random, out.count);
        for (int c = 0; c < 3; ++c) out.channels[static_cast<size_t>(c)].add(path.radiance[c]);
    }
    EXPECT_EQ(out.count.all_faults(), 0u);
    return out;
}

inline TrackerChoice forced(const Media& media, TrackerKind kind) {
    ChoiceParams params;
    params.forced = kind;
    return choose_tracker(facts_of(media), params);
}

/// All that render media whose density varies.
inline const std::vector<TrackerKind>& heterogeneous_trackers() {
    static const std::vector<TrackerKind> kinds = {TrackerKind::kDelta,
                                                   TrackerKind::kWeightedDelta,
                                                   TrackerKind::kAnalogDecomposition,
                                                   TrackerKind::kWeightedDecomposition,
                                                   TrackerKind::kSpectralMax,
                                                   TrackerKind::kSpectralAverage,
                                                   TrackerKind::kHistoryMax,
                                                   TrackerKind::kHistoryAverage,
                                                   TrackerKind::kSpectralMaxDecomposition,
                                                   TrackerKind::kHistoryAverageDecomposition,
                                                   TrackerKind::kSpectralMis};
    return kinds;
}

/// |mean − exact| within `bar` standard errors; exact where nothing varies.
inline void expect_mean(const MeanRadiance& got, int channel, double exact, double bar = 4.0) {
    EXPECT_NEAR(got.mean(channel), exact, bar * got.sigma(channel) + 1e-9 * exact)
        << "channel " << channel << ", standard error " << got.sigma(channel);
}

}  // namespace probebake::test
