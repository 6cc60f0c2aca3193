// Where voxels of hand-made .vox files land, and in what colours.
#include "scene/vox/vox_import.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "scene/vox/vox_palette.h"
#include "scene/vox_writer.h"
#include "voxels/voxel_tree.h"

namespace probebake {
namespace {

using test::packed_rotation;
using test::VoxContent;
using test::VoxWriter;

VoxImport import(const VoxWriter& writer) { return import_vox(writer.file(), "test.vox"); }

/// Colour index by position in the file's own space (Z up), for files with VoxWriter::palette():
/// its red channel tells the index. Of several voxels at a position the last order counts.
using Placed = std::map<std::tuple<int, int, int>, int>;

Placed placed(const VoxImport& result) {
    VoxPalette palette{};
    for (size_t i = 1; i < 256; ++i) {
        palette[i] = {static_cast<uint8_t>(i), static_cast<uint8_t>(255 - i), 7, 255};
    }
    const VoxColors colors = linear_colors(palette, {});
    std::vector<Voxel> voxels = result.cloud.voxels;
    std::sort(voxels.begin(), voxels.end(),
              [](const Voxel& a, const Voxel& b) { return a.key < b.key; });
    Placed at;
    for (const Voxel& v : voxels) {
        const IVec3 p = morton_decode(v.morton()) + result.lowest;
        const auto color = std::find(colors.albedo.begin(), colors.albedo.end(), v.albedo);
        at[{p.x, -p.z - 1, p.y}] = static_cast<int>(color - colors.albedo.begin());
    }
    return at;
}

Placed only(int x, int y, int z, int color) { return {{{x, y, z}, color}}; }

struct SignedPermutation {
    std::array<int, 3> axis{};
    std::array<int, 3> sign{};

    double determinant() const {
        glm::dmat3 rows(0.0);
        for (int i = 0; i < 3; ++i)
            rows[i][axis[static_cast<size_t>(i)]] = sign[static_cast<size_t>(i)];
        return glm::determinant(rows);
    }
    Vec3 operator*(const Vec3& v) const {
        Vec3 out;
        for (int i = 0; i < 3; ++i) {
            out[i] = sign[static_cast<size_t>(i)] * v[axis[static_cast<size_t>(i)]];
        }
        return out;
    }
};

std::vector<SignedPermutation> signed_permutations() {
    std::vector<SignedPermutation> all;
    std::array<int, 3> axis{0, 1, 2};
    do {
        for (int signs = 0; signs < 8; ++signs) {
            const auto sign = [&](int i) { return ((signs >> i) & 1) != 0 ? -1 : 1; };
            all.push_back({axis, {sign(0), sign(1), sign(2)}});
        }
    } while (std::next_permutation(axis.begin(), axis.end()));
    return all;
}

const std::vector<test::VoxelRow> kMarkers = {
    {0, 0, 0, 1}, {2, 0, 0, 2}, {0, 3, 0, 3}, {1, 2, 4, 4}};
const IVec3 kMarkerSize(3, 4, 5);

/// Where the markers' cell centres go under `map`, found in floating point.
template <class Map>
Placed marker_images(Map map) {
    Placed expected;
    for (const test::VoxelRow& row : kMarkers) {
        const Vec3 pivot(1.0, 2.0, 2.0);  // floor(size / 2)
        const Vec3 q = map(Vec3(row[0], row[1], row[2]) + 0.5 - pivot);
        expected[{static_cast<int>(std::floor(q.x)), static_cast<int>(std::floor(q.y)),
                  static_cast<int>(std::floor(q.z))}] = row[3];
    }
    return expected;
}

TEST(VoxImport, PutsTheModelsPivotAtTheOriginAndTurnsZUpToYUp) {
    const VoxImport result =
        import(VoxWriter().model({3, 4, 1}, {{0, 0, 0, 5}, {2, 3, 0, 9}}).palette());
    EXPECT_EQ(placed(result), (Placed{{{-1, -2, 0}, 5}, {{1, 1, 0}, 9}}));
    // y = −2 and 1 become z = 1 and −2.
    EXPECT_EQ(result.lowest, IVec3(-1, 0, -2));
    EXPECT_EQ(result.cloud.depth, 2);
    EXPECT_EQ(result.models, 1u);
    EXPECT_EQ(result.instances, 1u);
    EXPECT_EQ(result.rotated_instances, 0u);
    EXPECT_EQ(result.emissive_voxels, 0u);
    EXPECT_TRUE(result.warnings.empty());
}

TEST(VoxImport, EveryRotationAndMirrorImage) {
    int rotations = 0;
    for (const SignedPermutation& r : signed_permutations()) {
        const std::string packed = packed_rotation(r.axis, r.sign);
        const VoxImport result = import(VoxWriter()
                                            .model(kMarkerSize, kMarkers)
                                            .palette()
                                            .transform(0, 1)
                                            .group(1, {2})
                                            .transform(2, 3, {{"_r", packed}, {"_t", "10 -20 30"}})
                                            .shape(3, 0));
        EXPECT_EQ(placed(result),
                  marker_images([&](const Vec3& p) { return r * p + Vec3(10, -20, 30); }))
            << "_r " << packed;
        EXPECT_EQ(result.rotated_instances, packed == "4" ? 0u : 1u);
        if (r.determinant() > 0) ++rotations;
    }
    EXPECT_EQ(rotations, 24);
}

TEST(VoxImport, PacksRotationsAsDocumented) {
    // The example of MagicaVoxel-file-format-vox-extension.txt, (c).
    EXPECT_EQ(packed_rotation({1, 2, 0}, {1, -1, -1}),
              std::to_string((1 << 0) | (2 << 2) | (0 << 4) | (1 << 5) | (1 << 6)));
}

TEST(VoxImport, NestedTransformsApplyFromTheInside) {
    const std::vector<SignedPermutation> all = signed_permutations();
    for (size_t i = 0; i < all.size(); i += 5) {
        const SignedPermutation& outer = all[i];
        const SignedPermutation& inner = all[(7 * i + 3) % all.size()];
        const VoxImport result = import(
            VoxWriter()
                .model(kMarkerSize, kMarkers)
                .palette()
                .transform(0, 1, {{"_t", "1 2 3"}})
                .group(1, {2})
                .transform(2, 3, {{"_r", packed_rotation(outer.axis, outer.sign)}})
                .group(3, {4})
                .transform(4, 5,
                           {{"_t", "40 50 60"}, {"_r", packed_rotation(inner.axis, inner.sign)}})
                .shape(5, 0));
        EXPECT_EQ(placed(result), marker_images([&](const Vec3& p) {
                      return outer * (inner * p + Vec3(40, 50, 60)) + Vec3(1, 2, 3);
                  }));
    }
}

TEST(VoxImport, InstancesShareAModel) {
    const VoxImport result = import(VoxWriter()
                                        .model({1, 1, 1}, {{0, 0, 0, 8}})
                                        .palette()
                                        .transform(0, 10)
                                        .group(10, {20, 30})
                                        .transform(20, 40, {{"_t", "5 0 0"}})
                                        .transform(30, 40, {{"_t", "-5 0 0"}})
                                        .shape(40, 0));
    EXPECT_EQ(placed(result), (Placed{{{5, 0, 0}, 8}, {{-5, 0, 0}, 8}}));
    EXPECT_EQ(result.instances, 2u);
    EXPECT_EQ(result.models, 1u);
}

/// Two models of one voxel each (colours 1 and 2), the second 10 along x.
VoxWriter two_instances(const test::Pairs& first, const test::Pairs& second, int layer = -1) {
    return VoxWriter()
        .model({1, 1, 1}, {{0, 0, 0, 1}})
        .model({1, 1, 1}, {{0, 0, 0, 2}})
        .palette()
        .transform(0, 1)
        .group(1, {2, 4})
        .transform(2, 3, {}, first)
        .shape(3, 0)
        .transform(4, 5, {{"_t", "10 0 0"}}, second, layer)
        .shape(5, 1);
}

TEST(VoxImport, LeavesOutHiddenNodes) {
    const Placed both{{{0, 0, 0}, 1}, {{10, 0, 0}, 2}};
    EXPECT_EQ(placed(import(two_instances({}, {{"_name", "x"}, {"_hidden", "0"}}))), both);
    const VoxImport result = import(two_instances({{"_hidden", "1"}}, {}));
    EXPECT_EQ(placed(result), only(10, 0, 0, 2));
    EXPECT_EQ(result.instances, 1u);
    EXPECT_EQ(result.hidden_instances, 1u);
    EXPECT_EQ(result.lowest, IVec3(10, 0, -1));
}

TEST(VoxImport, LeavesOutHiddenLayers) {
    VoxWriter writer = two_instances({}, {}, 3);
    writer.layer(2, {{"_hidden", "1"}}).layer(3, {{"_name", "lamps"}, {"_hidden", "1"}});
    const VoxImport result = import(writer);
    EXPECT_EQ(placed(result), only(0, 0, 0, 1));
    EXPECT_EQ(result.hidden_instances, 1u);
    // A layer that the file does not describe is visible.
    EXPECT_EQ(import(two_instances({}, {}, 3)).hidden_instances, 0u);
}

TEST(VoxImport, HidesEverythingBelowAHiddenNode) {
    const auto hidden_by = [](const test::Pairs& group, const test::Pairs& shape) {
        return import(VoxWriter()
                          .model({1, 1, 1}, {{0, 0, 0, 1}})
                          .transform(0, 1)
                          .group(1, {2, 2, 2}, group)
                          .transform(2, 3)
                          .shape(3, 0, shape));
    };
    EXPECT_EQ(hidden_by({}, {}).instances, 3u);
    for (const VoxImport& result :
         {hidden_by({{"_hidden", "1"}}, {}), hidden_by({}, {{"_hidden", "1"}})}) {
        EXPECT_EQ(result.instances, 0u);
        EXPECT_EQ(result.hidden_instances, 3u);
        EXPECT_TRUE(result.cloud.voxels.empty());
        EXPECT_EQ(result.cloud.depth, 2);
        EXPECT_EQ(result.warnings, std::vector<std::string>{"no voxel is visible"});
    }
}

TEST(VoxImport, LaterInstancesWinWhereTheyOverlap) {
    const auto overlap = [](const std::vector<int>& order) {
        VoxWriter writer;
        writer.model({2, 1, 1}, {{0, 0, 0, 1}, {1, 0, 0, 1}})
            .model({2, 1, 1}, {{0, 0, 0, 2}, {1, 0, 0, 2}})
            .palette()
            .transform(0, 1)
            .group(1, order)
            .transform(2, 3)
            .shape(3, 0)
            .transform(4, 5, {{"_t", "1 0 0"}})
            .shape(5, 1);
        return import(writer);
    };
    EXPECT_EQ(placed(overlap({2, 4})), (Placed{{{-1, 0, 0}, 1}, {{0, 0, 0}, 2}, {{1, 0, 0}, 2}}));
    EXPECT_EQ(placed(overlap({4, 2})), (Placed{{{-1, 0, 0}, 1}, {{0, 0, 0}, 1}, {{1, 0, 0}, 2}}));

    VoxImport result = overlap({2, 4});
    EXPECT_EQ(result.cloud.voxels.size(), 4u);
    const PackedRgb second = result.cloud.voxels[3].albedo;
    BuildStats stats;
    const VoxelTree tree = VoxelTree::build(std::move(result.cloud), &stats);
    EXPECT_EQ(stats.duplicates, 1u);
    const auto middle = tree.find_voxel(IVec3(0, 0, -1) - result.lowest);
    ASSERT_TRUE(middle.has_value());
    EXPECT_EQ(tree.colors().albedo.voxels[*middle], second);
}

TEST(VoxImport, LastVoxelOfAModelCountsAndColorZeroIsEmpty) {
    const VoxImport result =
        import(VoxWriter()
                   .model({4, 1, 1},
                          {{0, 0, 0, 1}, {1, 0, 0, 2}, {0, 0, 0, 3}, {1, 0, 0, 0}, {3, 0, 0, 4}})
                   .palette());
    EXPECT_EQ(placed(result), (Placed{{{-2, 0, 0}, 3}, {{1, 0, 0}, 4}}));
    EXPECT_EQ(result.cloud.voxels.size(), 2u);
}

TEST(VoxImport, ModelsDoNotSeeEachOthersVoxels) {
    // Both models have the same cells; the second must not take them for duplicates.
    const std::vector<test::VoxelRow> rows = {{0, 0, 0, 1}, {1, 0, 0, 1}};
    const VoxImport result = import(VoxWriter()
                                        .model({2, 1, 1}, rows)
                                        .model({2, 1, 1}, rows)
                                        .transform(0, 1)
                                        .group(1, {2, 4})
                                        .transform(2, 3)
                                        .shape(3, 0)
                                        .transform(4, 5, {{"_t", "0 0 9"}})
                                        .shape(5, 1));
    EXPECT_EQ(result.cloud.voxels.size(), 4u);
}

TEST(VoxImport, TakesTheFirstFrameOfAnimations) {
    const std::vector<std::string> warning{"only the first frame of an animation is taken"};
    // Before the scene graph: the models of a PACK are frames.
    const VoxImport pack = import(VoxWriter()
                                      .chunk("PACK", VoxContent().i32(2))
                                      .model({1, 1, 1}, {{0, 0, 0, 1}})
                                      .model({1, 1, 1}, {{0, 0, 0, 2}})
                                      .palette());
    EXPECT_EQ(placed(pack), only(0, 0, 0, 1));
    EXPECT_EQ(pack.models, 2u);
    EXPECT_EQ(pack.warnings, warning);

    VoxWriter moving;
    moving.model({1, 1, 1}, {{0, 0, 0, 1}}).model({1, 1, 1}, {{0, 0, 0, 2}}).palette();
    moving.chunk("nTRN", VoxContent()
                             .i32(0)
                             .dictionary({})
                             .i32(1)
                             .i32(-1)
                             .i32(0)
                             .i32(2)
                             .dictionary({{"_t", "3 0 0"}, {"_f", "0"}})
                             .dictionary({{"_t", "4 0 0"}, {"_f", "5"}}));
    moving.chunk("nSHP",
                 VoxContent().i32(1).dictionary({}).i32(2).i32(1).dictionary({}).i32(0).dictionary(
                     {{"_f", "7"}}));
    const VoxImport result = import(moving);
    EXPECT_EQ(placed(result), only(3, 0, 0, 2));
    EXPECT_EQ(result.warnings, warning);
}

TEST(VoxImport, SkipsUnknownChunks) {
    VoxWriter writer;
    writer.chunk("rOBJ", VoxContent().text("anything at all"))
        .model({1, 1, 1}, {{0, 0, 0, 6}})
        .chunk("\x01\x02\xFFz", VoxContent(), VoxWriter().model({9, 9, 9}, {}).file())
        .chunk("MATT", VoxContent().i32(1))
        .palette();
    const VoxImport result = import(writer);
    EXPECT_EQ(placed(result), only(0, 0, 0, 6));
    EXPECT_EQ(result.models, 1u);
    EXPECT_EQ(result.warnings,
              std::vector<std::string>{"the old materials of chunk MATT are ignored"});
}

TEST(VoxImport, IndexMapOrdersTheEditorsPaletteOnly) {
    VoxContent reversed;
    for (int i = 0; i < 256; ++i) reversed.u8(static_cast<uint8_t>(255 - i));
    VoxWriter writer;
    writer.model({1, 1, 1}, {{0, 0, 0, 6}}).palette().chunk("IMAP", reversed);
    const VoxImport result = import(writer);
    EXPECT_EQ(placed(result), only(0, 0, 0, 6));
    EXPECT_TRUE(result.warnings.empty());

    VoxContent constant;
    for (int i = 0; i < 256; ++i) constant.u8(3);
    EXPECT_EQ(import(VoxWriter().model({1, 1, 1}, {{0, 0, 0, 6}}).chunk("IMAP", constant))
                  .warnings.size(),
              1u);
}

TEST(VoxImport, DoesNotDependOnThreads) {
    VoxWriter writer;
    writer.model(kMarkerSize, kMarkers).palette().transform(0, 1);
    std::vector<int> children(300);
    std::iota(children.begin(), children.end(), 2);
    writer.group(1, children);
    for (const int child : children) {
        writer.transform(child, 1000,
                         {{"_t", std::to_string(child % 17) + " 0 " + std::to_string(child % 5)}});
    }
    writer.shape(1000, 0);
    VoxImport one;
    VoxImport two;
    tbb::task_arena(1).execute([&] { one = import(writer); });
    tbb::task_arena(2).execute([&] { two = import(writer); });
    const auto values = [](const VoxImport& result) {
        std::vector<std::tuple<uint64_t, PackedRgb, PackedRgb>> list;
        for (const Voxel& v : result.cloud.voxels) list.emplace_back(v.key, v.albedo, v.emission);
        return list;
    };
    EXPECT_EQ(values(one), values(two));
    EXPECT_EQ(one.cloud.voxels.size(), 1200u);
}

}  // namespace
}  // namespace probebake
