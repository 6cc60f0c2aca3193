#include "study/octrees/measure.h"

#include <tbb/parallel_for.h>

#include <ctime>
#include <span>

#include "study/octrees/spd_rays.h"

namespace probebake::study {
namespace {

struct Method {
    const char* name;
    OctreeTraversal walk;
};
struct Tree {
    SplitPlanes planes;
    std::vector<Method> methods;
};
const std::vector<Tree>& trees() {
    static const std::vector<Tree> list = {
        {SplitPlanes::kCenter,
         {{"Octree84-C", OctreeTraversal::kFromRoot},
          {"Octree89-C", OctreeTraversal::kFromAncestor},
          {"Octree93-C", OctreeTraversal::kTopDown}}},
        {SplitPlanes::kCostEstimate,
         {{"Octree84-A", OctreeTraversal::kFromRoot}, {"Octree93-A", OctreeTraversal::kTopDown}}}};
    return list;
}

/// CPU time of the calling thread.
double thread_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Measured {
    CastCounts counts;
    double seconds = 0.0;
};
struct Chunk {
    std::vector<Measured> methods;
    uint64_t disagreements = 0;
    uint64_t changed_hits = 0;
};

constexpr size_t kChunkRays = 4096;

ObjectHit cast(const ObjectOctree& octree, const SpdRay& ray, OctreeTraversal walk,
               CastCounts& counts) {
    return ray.kind == SpdRayKind::kShadow ? octree.any_hit(ray.ray, ray.range, walk, counts)
                                           : octree.closest_hit(ray.ray, ray.range, walk, counts);
}

/// Some rays with every method in turn; who comes first changes from chunk to chunk, since it finds
/// the caches cold.
Chunk measure_chunk(const ObjectOctree& octree, std::span<const SpdRay> rays,
                    const std::vector<Method>& methods, size_t first) {
    Chunk chunk;
    chunk.methods.resize(methods.size());
    std::vector<std::vector<ObjectHit>> hits(methods.size(), std::vector<ObjectHit>(rays.size()));
    for (size_t k = 0; k < methods.size(); ++k) {
        const size_t m = (first + k) % methods.size();
        CastCounts counts;
        const double begin = thread_seconds();
        for (size_t i = 0; i < rays.size(); ++i) {
            hits[m][i] = cast(octree, rays[i], methods[m].walk, counts);
        }
        chunk.methods[m] = {counts, thread_seconds() - begin};
    }
    for (size_t i = 0; i < rays.size(); ++i) {
        const ObjectHit& hit = hits[0][i];
        bool same = true;
        for (size_t m = 1; m < methods.size(); ++m) same = same && hits[m][i] == hit;
        if (!same) ++chunk.disagreements;
        const ObjectHit& expected = rays[i].hit;
        const bool as_expected = rays[i].kind == SpdRayKind::kShadow
                                     ? static_cast<bool>(hit) == static_cast<bool>(expected)
                                     : hit.object == expected.object;
        if (!as_expected) ++chunk.changed_hits;
    }
    return chunk;
}

Chunk measure_rays(const ObjectOctree& octree, std::span<const SpdRay> rays,
                   const std::vector<Method>& methods) {
    const size_t count = (rays.size() + kChunkRays - 1) / kChunkRays;
    std::vector<Chunk> chunks(count);
    tbb::parallel_for(size_t{0}, count, [&](size_t i) {
        const size_t begin = i * kChunkRays;
        chunks[i] = measure_chunk(
            octree, rays.subspan(begin, std::min(kChunkRays, rays.size() - begin)), methods, i);
    });
    Chunk total;
    total.methods.resize(methods.size());
    for (const Chunk& chunk : chunks) {
        for (size_t m = 0; m < methods.size(); ++m) {
            total.methods[m].counts += chunk.methods[m].counts;
            total.methods[m].seconds += chunk.methods[m].seconds;
        }
        total.disagreements += chunk.disagreements;
        total.changed_hits += chunk.changed_hits;
    }
    return total;
}

Json row_of(const Method& method, int depth, const ItemOctreeCounts& tree, double build_seconds,
            const Measured& measured) {
    return {{"method", method.name},
            {"depth", depth},
            {"inner", tree.inner},
            {"tree_leaves", tree.leaves},
            {"tree_empty_leaves", tree.empty_leaves},
            {"references", tree.references},
            {"tests", measured.counts.tests},
            {"steps", measured.counts.walk.steps},
            {"leaves", measured.counts.walk.leaves},
            {"empty_leaves", measured.counts.walk.empty_leaves},
            {"build_seconds", build_seconds},
            {"trace_seconds", measured.seconds}};
}

}  // namespace

Json measure_scene(const NffScene& scene, const MeasureParams& params,
                   const std::function<void(const std::string& what)>& on_progress) {
    on_progress("rays");
    const ObjectOctree safe(scene.shapes, safe_boxes(scene.shapes), {.max_depth = 7});
    const std::vector<SpdRay> rays = spd_rays(scene, safe, {.size_px = params.size_px});
    const SpdRayCounts ray_counts = count_rays(rays);
    const Box& box = safe.octree().tree().box();
    Json result = {
        {"objects", scene.shapes.size()},
        {"box", {box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z}},
        {"rays", {{"cast", ray_counts.cast}, {"used", ray_counts.used}}},
        {"rows", Json::array()}};
    uint64_t disagreements = 0;
    uint64_t changed_hits = 0;
    for (const Tree& tree : trees()) {
        for (const int depth : params.depths) {
            on_progress(std::string(tree.planes == SplitPlanes::kCenter ? "centre" : "cost") +
                        " planes, depth " + std::to_string(depth));
            const double begin = thread_seconds();
            const ObjectOctree octree(scene.shapes, boxes_1999(scene.shapes),
                                      {.max_depth = depth, .planes = tree.planes});
            const double build_seconds = thread_seconds() - begin;
            const Chunk measured = measure_rays(octree, rays, tree.methods);
            for (size_t m = 0; m < tree.methods.size(); ++m) {
                result["rows"].push_back(row_of(tree.methods[m], depth, octree.octree().counts(),
                                                build_seconds, measured.methods[m]));
            }
            disagreements += measured.disagreements;
            changed_hits += measured.changed_hits;
        }
    }
    result["disagreements"] = disagreements;
    result["changed_hits"] = changed_hits;
    return result;
}

}  // namespace probebake::study
