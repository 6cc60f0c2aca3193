#include "voxels/trace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "support/random_cloud.h"
#include "support/ray_families.h"

namespace probebake {
namespace {

/// An octree without any cleverness: the set of non-empty node positions of every level, and a
/// recursion that orders the children by where the ray enters them.
class BruteForce {
  public:
    explicit BruteForce(const VoxelCloud& cloud)
        : depth_(cloud.depth), levels_(static_cast<size_t>(cloud.depth) + 1) {
        for (const Voxel& voxel : cloud.voxels) {
            for (size_t level = 0; level < levels_.size(); ++level) {
                levels_[level].insert(voxel.morton() >> (3 * level));
            }
        }
    }

    struct Interval {
        double enter;
        double exit;
    };
    static Interval interval(const Ray& ray, const IVec3& corner, int edge) {
        const Vec3 d = safe_direction(ray.direction);
        Interval result{-std::numeric_limits<double>::infinity(),
                        std::numeric_limits<double>::infinity()};
        for (int a = 0; a < 3; ++a) {
            const double t0 = (corner[a] - ray.origin[a]) * (1.0 / d[a]);
            const double t1 = (corner[a] + edge - ray.origin[a]) * (1.0 / d[a]);
            result.enter = std::max(result.enter, std::min(t0, t1));
            result.exit = std::min(result.exit, std::max(t0, t1));
        }
        return result;
    }

    Hit trace(const Ray& ray, const LevelOfDetail& lod, const TraceRange& range) const {
        Hit hit;
        const Interval root = interval(ray, {0, 0, 0}, 1 << depth_);
        if (levels_[0].empty() || !(root.enter < root.exit) || !(root.exit > range.t_min))
            return hit;
        descend(0, depth_, ray, lod, range, hit);
        return hit;
    }

    /// Nearest voxel in extended precision and by division; independent of the double arithmetic.
    /// No value where the answer hangs on a graze shorter than `tolerance`.
    std::optional<double> nearest_voxel(const Ray& ray, const TraceRange& range,
                                        long double tolerance) const {
        long double nearest = std::numeric_limits<long double>::infinity();
        long double nearest_grazed = nearest;
        const Vec3 direction = safe_direction(ray.direction);
        for (const uint64_t code : levels_[0]) {
            const IVec3 p = morton_decode(code);
            long double enter = -std::numeric_limits<long double>::infinity();
            long double exit = -enter;
            for (int a = 0; a < 3; ++a) {
                const long double d = direction[a];
                const long double t0 = (static_cast<long double>(p[a]) - ray.origin[a]) / d;
                const long double t1 = (static_cast<long double>(p[a]) + 1 - ray.origin[a]) / d;
                enter = std::max(enter, std::min(t0, t1));
                exit = std::min(exit, std::max(t0, t1));
            }
            const bool surely = exit - enter > tolerance && enter > range.t_min + tolerance;
            const bool maybe = exit - enter > -tolerance && enter > range.t_min - tolerance;
            if (surely) nearest = std::min(nearest, enter);
            if (maybe) nearest_grazed = std::min(nearest_grazed, enter);
        }
        if (nearest_grazed < nearest - tolerance) return std::nullopt;
        return static_cast<double>(nearest);
    }

  private:
    /// True where the search is over.
    bool descend(uint64_t node, int level, const Ray& ray, const LevelOfDetail& lod,
                 const TraceRange& range, Hit& hit) const {
        struct Child {
            double enter;
            uint64_t code;
        };
        std::vector<Child> children;
        const int child_level = level - 1;
        for (uint64_t octant = 0; octant < 8; ++octant) {
            const uint64_t code = node << 3 | octant;
            if (!levels_[static_cast<size_t>(child_level)].contains(code)) continue;
            const Interval in =
                interval(ray, morton_decode(code << (3 * child_level)), 1 << child_level);
            if (in.enter < in.exit && in.exit > range.t_min) children.push_back({in.enter, code});
        }
        std::sort(children.begin(), children.end(),
                  [](const Child& a, const Child& b) { return a.enter < b.enter; });
        for (const Child& child : children) {
            if (child.enter > range.t_max) return true;
            ++hit.steps;
            const bool opaque =
                child_level <= lod.fixed_level || (1 << child_level) <= lod.cone * child.enter;
            if (opaque && child.enter >= range.t_min) {
                hit.t = child.enter;
                hit.level = child_level;
                hit.corner = morton_decode(child.code << (3 * child_level));
                return true;
            }
            if (child_level > 0 && descend(child.code, child_level, ray, lod, range, hit)) {
                return true;
            }
        }
        return false;
    }

    int depth_;
    std::vector<std::set<uint64_t>> levels_;
};

struct Mode {
    const char* name;
    LevelOfDetail lod;
    TraceRange range;
};

const Mode kModes[] = {
    {"leaves", {}, {}},
    {"fixed level 1", {.fixed_level = 1}, {}},
    {"fixed level 2", {.fixed_level = 2}, {}},
    {"narrow cone", {.cone = 0.01}, {}},
    {"wide cone", {.cone = 0.3}, {}},
    {"near and far", {}, {.t_min = 1.7, .t_max = 20.3}},
    {"cone, near and far", {.cone = 0.1}, {.t_min = 3.0, .t_max = 30.0}},
};

constexpr int kRaysPerFamily = 1800;

void expect_same(const Hit& got, const Hit& expected, const std::string& what) {
    ASSERT_EQ(got.level, expected.level) << what;
    ASSERT_EQ(got.steps, expected.steps) << what;
    if (!expected) return;
    ASSERT_EQ(got.t, expected.t) << what;
    ASSERT_EQ(got.corner, expected.corner) << what;
}

TEST(Trace, AgreesWithBruteForceOnEveryRayFamily) {
    for (const auto& [cloud_name, cloud] : test::named_clouds()) {
        const VoxelTree tree = VoxelTree::build(cloud);
        const BruteForce brute(cloud);
        const double side = 1 << cloud.depth;
        uint64_t family_index = 0;
        for (const test::RayFamily& family : test::ray_families()) {
            RandomStream random(
                random_key({1, family_index++, static_cast<uint64_t>(cloud.depth)}));
            for (int i = 0; i < kRaysPerFamily; ++i) {
                const Ray ray = family.make(random, side);
                const Mode& mode = kModes[static_cast<size_t>(i) % std::size(kModes)];
                const std::string what = cloud_name + ", " + family.name + ", " + mode.name +
                                         ", ray " + std::to_string(i);
                const Hit got = trace(tree, ray, mode.lod, mode.range);
                if (!family.well_defined) {
                    ASSERT_FALSE(got) << what;
                    continue;
                }
                ASSERT_NO_FATAL_FAILURE(
                    expect_same(got, brute.trace(ray, mode.lod, mode.range), what));
            }
        }
    }
}

TEST(Trace, OneWalkFindsTheLeafAndTheNodeOnTheWay) {
    int passed = 0;
    for (const auto& [cloud_name, cloud] : test::named_clouds()) {
        const VoxelTree tree = VoxelTree::build(cloud);
        uint64_t family_index = 0;
        for (const test::RayFamily& family : test::ray_families()) {
            RandomStream random(
                random_key({3, family_index++, static_cast<uint64_t>(cloud.depth)}));
            for (int i = 0; i < 200; ++i) {
                const Ray ray = family.make(random, 1 << cloud.depth);
                const Mode& mode = kModes[static_cast<size_t>(i) % std::size(kModes)];
                const std::string what = cloud_name + ", " + family.name + ", " + mode.name;
                const auto [leaf, node] = trace_through(tree, ray, mode.lod, mode.range);
                const Hit only_leaf = trace(tree, ray, {}, mode.range);
                Hit only_node = trace(tree, ray, mode.lod, mode.range);
                ASSERT_LE(only_node.steps, leaf.steps) << what;
                only_node.steps = leaf.steps;
                ASSERT_NO_FATAL_FAILURE(expect_same(leaf, only_leaf, what));
                ASSERT_NO_FATAL_FAILURE(expect_same(node, only_node, what));
                if (node && !(leaf && leaf.t == node.t)) ++passed;
            }
        }
    }
    EXPECT_GT(passed, 100) << "rays that go through a node";
}

TEST(Trace, AgreesWithExtendedPrecisionWhereNothingIsGrazed) {
    int decided = 0;
    for (const auto& [cloud_name, cloud] : test::named_clouds()) {
        const VoxelTree tree = VoxelTree::build(cloud);
        const BruteForce brute(cloud);
        const double side = 1 << cloud.depth;
        for (const test::RayFamily& family : test::ray_families()) {
            if (!family.well_defined) continue;
            RandomStream random(random_key({2, static_cast<uint64_t>(cloud.depth)}));
            for (int i = 0; i < 50; ++i) {
                Ray ray = family.make(random, side);
                const double length = glm::length(ray.direction);
                const double reach = std::max(side, glm::length(ray.origin));
                const long double tolerance = 1e-12L * reach / length;
                const auto expected = brute.nearest_voxel(ray, {}, tolerance);
                if (!expected) continue;
                ++decided;
                const Hit got = trace(tree, ray);
                if (std::isinf(*expected)) {
                    ASSERT_FALSE(got) << cloud_name << ", " << family.name << ", ray " << i;
                } else {
                    ASSERT_TRUE(got) << cloud_name << ", " << family.name << ", ray " << i;
                    ASSERT_NEAR(got.t, *expected, static_cast<double>(tolerance))
                        << cloud_name << ", " << family.name << ", ray " << i;
                }
            }
        }
    }
    EXPECT_GT(decided, 4000);  // the oracle abstains only on grazing rays
}

TEST(Trace, AncestorsEntryFaceAndMasksDescribeTheHit) {
    const VoxelCloud cloud = test::random_cloud(5, 0.05, 33);
    const VoxelTree tree = VoxelTree::build(cloud);
    const auto contains = [&](const IVec3& corner, int level) {
        for (const Voxel& voxel : cloud.voxels) {
            const IVec3 p = morton_decode(voxel.morton());
            if ((p.x >> level) == (corner.x >> level) && (p.y >> level) == (corner.y >> level) &&
                (p.z >> level) == (corner.z >> level)) {
                return true;
            }
        }
        return false;
    };
    const auto mask_at = [&](const IVec3& corner, int level) {
        uint8_t mask = 0;
        for (int octant = 0; octant < 8; ++octant) {
            const int edge = 1 << (level - 1);
            const IVec3 child = corner + IVec3(octant & 1, (octant >> 1) & 1, octant >> 2) * edge;
            if (contains(child, level - 1)) mask = static_cast<uint8_t>(mask | (1 << octant));
        }
        return mask;
    };
    RandomStream random(9);
    int hits = 0;
    for (int i = 0; i < 400; ++i) {
        const Ray ray = test::towards(random, test::random_point(random, 32.0), 80.0);
        const int level = i % 5;
        const Hit hit = trace(tree, ray, {.fixed_level = level});
        if (!hit) continue;
        ++hits;
        ASSERT_EQ(hit.level, level);

        const Vec3 point = ray.origin + ray.direction * hit.t;
        const int axis = axis_of(hit.entry_face);
        const bool positive = index_of(hit.entry_face) % 2 == 0;
        EXPECT_NEAR(point[axis], hit.corner[axis] + (positive ? 1 << level : 0), 1e-9);
        EXPECT_EQ(ray.direction[axis] < 0, positive);

        // The colour index of every ancestor, checked through the colours themselves.
        const auto color_of = [&](const IVec3& corner, int at) {
            Vec3 sum(0.0);
            const auto mean = [&](auto&& self, const IVec3& c, int l) -> Vec3 {
                if (l == 0)
                    return Vec3(unpack_rgb(tree.colors().albedo.voxels[*tree.find_voxel(c)]));
                Vec3 total(0.0);
                int count = 0;
                for (int octant = 0; octant < 8; ++octant) {
                    const IVec3 child =
                        c + IVec3(octant & 1, (octant >> 1) & 1, octant >> 2) * (1 << (l - 1));
                    if (!contains(child, l - 1)) continue;
                    total += self(self, child, l - 1);
                    ++count;
                }
                return total / static_cast<double>(count);
            };
            sum = mean(mean, corner, at);
            return sum;
        };
        if (hits <= 40) {
            for (int at = level; at <= 4; ++at) {
                const IVec3 corner((hit.corner.x >> at) << at, (hit.corner.y >> at) << at,
                                   (hit.corner.z >> at) << at);
                const Rgb got = tree.colors().albedo[color_index(tree, hit, at)];
                const Vec3 expected = color_of(corner, at);
                for (int c = 0; c < 3; ++c) ASSERT_NEAR(got[c], expected[c], 1.0 / 256) << at;
            }
        }

        const ChildMasks masks = child_masks(tree, hit);
        if (level == 0) {
            EXPECT_EQ(masks.own, 255);
            EXPECT_EQ(masks.child_count, 0);
            continue;
        }
        EXPECT_EQ(masks.own, mask_at(hit.corner, level));
        int child = 0;
        for (int octant = 0; octant < 8; ++octant) {
            if (((masks.own >> octant) & 1) == 0) continue;
            const IVec3 corner =
                hit.corner + IVec3(octant & 1, (octant >> 1) & 1, octant >> 2) * (1 << (level - 1));
            const uint8_t expected = level == 1 ? 255 : mask_at(corner, level - 1);
            ASSERT_EQ(masks.children[static_cast<size_t>(child++)], expected);
        }
        EXPECT_EQ(masks.child_count, child);
    }
    EXPECT_GT(hits, 200);
}

TEST(Trace, AVoxelThatHoldsTheOriginIsPassedThrough) {
    const VoxelTree tree =
        VoxelTree::build({.voxels = {make_voxel({0, 0, 0}, 1), make_voxel({2, 0, 0}, 2)}});
    const Hit hit = trace(tree, {{0.5, 0.5, 0.5}, {1.0, 0.0, 0.0}});
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit.t, 1.5);
    EXPECT_EQ(hit.corner, IVec3(2, 0, 0));
    EXPECT_EQ(trace(tree, {{2.0, 0.5, 0.5}, {1.0, 0.0, 0.0}}).t, 0.0);  // begins at its face
}

}  // namespace
}  // namespace probebake
