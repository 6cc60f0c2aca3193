// What a piece of rendering cost, as plain counters: passed in, merged in a fixed order, never
// shared between threads.
#pragma once

#include <array>
#include <cstdint>

#include "voxels/trace.h"

namespace probebake {

/// Of paths through media; all 0 in scenes without.
struct MediaCost {
    uint64_t lookups = 0;     // of coefficients
    uint64_t leaves = 0;      // pieces of media entered: octree leaves, stretches of fog
    uint64_t collisions = 0;  // real ones
    uint64_t null_collisions = 0;
    uint64_t scatterings = 0;  // in media and at surfaces
    uint64_t shadow_rays = 0;  // whose steps are among CostStats::steps
    uint64_t faults = 0;       // paths given up, bounds that did not bound

    bool operator==(const MediaCost&) const = default;
    MediaCost& operator+=(const MediaCost& other) {
        lookups += other.lookups;
        leaves += other.leaves;
        collisions += other.collisions;
        null_collisions += other.null_collisions;
        scatterings += other.scatterings;
        shadow_rays += other.shadow_rays;
        faults += other.faults;
        return *this;
    }
};

struct CostStats {
    uint64_t rays = 0;            // whose colour is part of a pixel
    uint64_t discarded_rays = 0;  // cast, judged too coarse, replaced by finer ones
    uint64_t missed_rays = 0;     // of `rays`: those that met nothing within their range
    uint64_t steps = 0;           // octree nodes entered, by rays and by beams (start_list.h)
    uint64_t box_tests = 0;       // start nodes that rays were tested against
    /// Kept rays that hit, by the octree level at which they stopped.
    std::array<uint64_t, kMaxDepth + 1> level_histogram{};
    double seconds = 0.0;  // summed over threads
    MediaCost media;

    uint64_t all_rays() const { return rays + discarded_rays; }
    uint64_t hits() const { return rays - missed_rays; }
    /// What it came to, whatever the machine: shares of cost are shares of this.
    uint64_t counted() const { return steps + media.lookups + media.leaves; }

    void keep(const Hit& hit) {
        ++rays;
        steps += hit.steps;
        box_tests += hit.box_tests;
        if (hit) {
            ++level_histogram[static_cast<size_t>(hit.level)];
        } else {
            ++missed_rays;
        }
    }
    void discard(const Hit& hit) {
        ++discarded_rays;
        steps += hit.steps;
        box_tests += hit.box_tests;
    }

    /// Counts everything of `other` as discarded.
    void discard_all(const CostStats& other) {
        discarded_rays += other.all_rays();
        steps += other.steps;
        box_tests += other.box_tests;
    }

    CostStats& operator+=(const CostStats& other) {
        rays += other.rays;
        discarded_rays += other.discarded_rays;
        missed_rays += other.missed_rays;
        steps += other.steps;
        box_tests += other.box_tests;
        for (size_t i = 0; i < level_histogram.size(); ++i) {
            level_histogram[i] += other.level_histogram[i];
        }
        seconds += other.seconds;
        media += other.media;
        return *this;
    }
};

}  // namespace probebake
