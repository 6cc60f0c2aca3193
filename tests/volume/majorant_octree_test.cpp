#include "volume/majorant_octree.h"

#include <tbb/global_control.h>

#include <functional>

#include "support/ray_families.h"
#include "volume/volume_fixture.h"

namespace probebake {
namespace {

/// Every leaf as (depth, low corner in cells from the grid's, edge in cells, node).
void for_each_leaf(
    const MajorantOctree& tree, double root_edge,
    const std::function<void(int, const Vec3&, double, const MajorantOctree::Node&)>& visit) {
    const std::function<void(uint32_t, int, Vec3, double)> walk =
        [&](uint32_t index, int depth, const Vec3& low, double edge) {
            const MajorantOctree::Node& node = tree.nodes()[index];
            if (node.first_child == 0) {
                visit(depth, low, edge, node);
                return;
            }
            for (uint32_t c = 0; c < 8; ++c) {
                walk(node.first_child + c, depth + 1,
                     low + Vec3(c & 1, c >> 1 & 1, c >> 2) * (0.5 * edge), 0.5 * edge);
            }
        };
    walk(0, 1, Vec3(0.0), root_edge);
}

/// Bounds over a box of index space by every lattice point in it and the box's own corners.
DensityGrid::Bounds brute_force(const DensityGrid& grid, const Vec3& low, double edge) {
    DensityGrid::Bounds bounds{1e30f, 0.0f};
    const Vec3 high = glm::min(low + edge, Vec3(grid.low() + grid.cells()));
    for (double z = low.z; z <= high.z; z += std::min(1.0, edge)) {
        for (double y = low.y; y <= high.y; y += std::min(1.0, edge)) {
            for (double x = low.x; x <= high.x; x += std::min(1.0, edge)) {
                const auto v = static_cast<float>(grid.sample({x, y, z}));
                bounds.least = std::min(bounds.least, v);
                bounds.most = std::max(bounds.most, v);
            }
        }
    }
    return bounds;
}

TEST(MajorantOctree, BoundsAreExactAtEveryDepth) {
    const IVec3 low(-3, 2, 5);
    const DensityGrid grid = test::noise_grid(low, {29, 17, 23}, 3);
    for (const int depth : {1, 2, 4, 6, 8}) {
        const MajorantOctree tree(grid, {.max_depth = depth, .threshold = 1e-9});
        EXPECT_EQ(tree.depth_reached(), depth);
        int leaves = 0;
        for_each_leaf(tree, 32.0, [&](int d, const Vec3& at, double edge, const auto& node) {
            EXPECT_LE(d, depth);
            if (!glm::all(glm::lessThan(at, Vec3(grid.cells())))) {
                EXPECT_EQ(node.most, 0.0f);
                return;
            }
            const auto exact = brute_force(grid, Vec3(low) + at, edge);
            const float slack = edge < 1.0 ? 3e-6f : 0.0f;
            ASSERT_LE(node.least, exact.least);
            ASSERT_GE(node.most, exact.most);
            ASSERT_GE(node.least, exact.least - slack * (1.0f + exact.least));
            ASSERT_LE(node.most, exact.most + slack * (1.0f + exact.most));
            ++leaves;
        });
        EXPECT_GT(leaves, 0);
    }
}

TEST(MajorantOctree, SplitsWhereTheResidualIsThick) {
    const DensityGrid grid = test::noise_grid({0, 0, 0}, {40, 40, 40}, 4);
    const double scale = 0.1;
    const double threshold = 0.3;
    const MajorantOctree tree(grid, {.max_depth = 12, .threshold = threshold, .scale = scale});
    EXPECT_LT(tree.depth_reached(), 12);
    double most = 0.0;
    double residual = 0.0;
    for_each_leaf(tree, 64.0, [&](int, const Vec3&, double edge, const auto& node) {
        EXPECT_LE(double{node.most - node.least} * edge * scale, threshold);
        most += double{node.most} * edge * edge * edge;
        residual += double{node.most - node.least} * edge * edge * edge;
    });
    EXPECT_NEAR(tree.residual_share(), residual / most, 1e-6);
    EXPECT_EQ(MajorantOctree(grid, {.max_depth = 12, .threshold = 1e9}).leaf_count(), 1u);
}

TEST(MajorantOctree, MemoryIsBounded) {
    const DensityGrid grid = test::noise_grid({0, 0, 0}, {20, 20, 20}, 11);
    const MajorantOctree tree(
        grid, {.max_depth = 16, .threshold = 1e-6, .scale = 1.0, .most_nodes = 50000});
    EXPECT_LE(tree.nodes().size(), 50000u);
    EXPECT_GT(tree.nodes().size(), 5000u);
    EXPECT_LT(tree.depth_reached(), 16);
}

TEST(MajorantOctree, IsTheSameForAnyNumberOfThreads) {
    const DensityGrid grid = test::noise_grid({0, 0, 0}, {60, 50, 40}, 5);
    const MajorantParams params{.max_depth = 7, .threshold = 0.1};
    const MajorantOctree parallel(grid, params);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(MajorantOctree(grid, params).nodes(), parallel.nodes());
}

TEST(MajorantOctree, ParametersOutOfRangeAreRefused) {
    const DensityGrid grid = test::noise_grid({0, 0, 0}, {4, 4, 4}, 6);
    for (const int depth : {0, 17}) {
        EXPECT_THROW(MajorantOctree(grid, {.max_depth = depth}), std::invalid_argument);
    }
    EXPECT_THROW(MajorantOctree(grid, {.threshold = 0.0}), std::invalid_argument);
    EXPECT_THROW(MajorantOctree(grid, {.scale = std::nan("")}), std::invalid_argument);
    EXPECT_NO_THROW(MajorantOctree(grid, {.max_depth = 16, .threshold = 1e-3}));
}

// The leaves of a walk tile the ray's part of the grid's box, and bound what lies along them.
TEST(OctreeWalk, LeavesTileTheRayAndBoundItsDensities) {
    const DensityGrid grid = test::noise_grid({0, 0, 0}, {32, 32, 32}, 7);
    for (const int depth : {1, 3, 6, 8, 16}) {
        const MajorantOctree tree(grid, {.max_depth = depth, .threshold = 0.2});
        for (const test::RayFamily& family : test::ray_families()) {
            if (!family.well_defined) continue;
            RandomStream random(random_key({8, static_cast<uint64_t>(depth)}));
            int met = 0;
            for (int i = 0; i < 200; ++i) {
                Ray ray = family.make(random, 32.0);
                const Ray units{tree.index_to_units().point(ray.origin),
                                tree.index_to_units().vector(ray.direction)};
                const auto inside =
                    clip(tree.box_units(), {units.origin, safe_direction(units.direction)}, {});
                OctreeWalk walk(tree, units, {});
                DensitySegment leaf;
                double t = inside ? inside->begin : 0.0;
                int leaves = 0;
                while (walk.next(leaf)) {
                    ASSERT_TRUE(inside) << family.name;
                    ASSERT_EQ(leaf.t0, t) << family.name;
                    ASSERT_LE(leaf.t0, leaf.t1);
                    ASSERT_LT(++leaves, 100000) << family.name;
                    t = leaf.t1;
                    for (const double f : {0.01, 0.5, 0.99}) {
                        const double at = leaf.t0 + f * (leaf.t1 - leaf.t0);
                        const double d = grid.sample(ray.origin + ray.direction * at);
                        // Far origins leave few digits for the place.
                        const double slack = 1e-9 + 1e-15 * glm::length(ray.origin) * 50.0;
                        ASSERT_GE(d, leaf.least - slack) << family.name;
                        ASSERT_LE(d, leaf.most + slack) << family.name;
                    }
                }
                if (!inside) continue;
                ASSERT_EQ(t, inside->end) << family.name;
                ++met;
            }
            if (family.name == "generic") {
                EXPECT_GT(met, 100);
            }
        }
    }
}

TEST(OctreeWalk, RaysWithoutMeaningMeetNothing) {
    const DensityGrid grid = test::noise_grid({0, 0, 0}, {8, 8, 8}, 9);
    const MajorantOctree tree(grid, {});
    RandomStream random(10);
    for (const test::RayFamily& family : test::ray_families()) {
        if (family.well_defined) continue;
        for (int i = 0; i < 200; ++i) {
            OctreeWalk walk(tree, family.make(random, 8.0), {0.0, 1e6});
            DensitySegment leaf;
            int leaves = 0;
            while (walk.next(leaf) && leaves < 10000) ++leaves;
            EXPECT_LT(leaves, 10000) << family.name;
        }
    }
}

}  // namespace
}  // namespace probebake
