#include "voxels/tree_file.h"

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/io_error.h"
#include "support/random_cloud.h"

namespace probebake {
namespace {

std::filesystem::path temporary_file() {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    return std::filesystem::path(testing::TempDir()) / ("probebake-tree-" + name);
}

TEST(TreeFile, ReadsBackEveryKindOfTree) {
    const auto path = temporary_file();
    for (auto& [name, cloud] : test::named_clouds()) {
        const VoxelTree tree = VoxelTree::build(cloud);
        save_tree(path, tree);
        EXPECT_TRUE(load_tree(path).tree == tree) << name;
    }
    VoxelCloud lit = test::random_cloud(3, 0.2, 5);
    lit.emission_scale = 64.0f;
    lit.voxels[0].emission = pack_rgb(Rgb(1.0f, 2.0f, 3.0f));
    const VoxelTree tree = VoxelTree::build(lit);
    save_tree(path, tree, "a note");
    EXPECT_TRUE(load_tree(path).tree == tree);
    EXPECT_EQ(load_tree(path).notes, "a note");
    std::filesystem::remove(path);
}

TEST(TreeFile, ADamagedFileIsAClearError) {
    const auto path = temporary_file();
    save_tree(path, VoxelTree::build(test::random_cloud(4, 0.2, 5)));
    const std::vector<std::byte> good = read_file(path);
    for (size_t i = 0; i < good.size(); i += 101) {
        std::vector<std::byte> bad = good;
        bad[i] ^= std::byte{4};
        write_file_atomically(path, bad);
        EXPECT_THROW(load_tree(path), IoError) << "byte " << i;
        write_file_atomically(path, std::span(good).first(i));
        EXPECT_THROW(load_tree(path), IoError) << "first " << i << " bytes";
    }
    std::filesystem::remove(path);
}

TEST(TreeFile, ATreeThatPointsOutsideItselfIsRefused) {
    const auto path = temporary_file();
    const VoxelTree good = VoxelTree::build(test::random_cloud(4, 0.2, 5));
    std::vector<VoxelNode> nodes(good.nodes().begin(), good.nodes().end());
    nodes[0].first_child += 1;
    VoxelTree bad(good.depth(), nodes, good.level_begins(), good.voxel_count(),
                  good.octant_count());
    bad.set_colors(good.colors());
    save_tree(path, bad);  // its checksum is right
    EXPECT_THROW(load_tree(path), IoError);
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace probebake
