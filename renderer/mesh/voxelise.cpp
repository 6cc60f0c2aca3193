#include "mesh/voxelise.h"

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "math/box.h"
#include "mesh/surface_check.h"
#include "mesh/triangle_box.h"
#include "mesh/voxel_look.h"
#include "voxels/solid_fill.h"
#include "voxels/tree_builder.h"

namespace probebake {
namespace {

constexpr int kBlockLevel = 6;  // log2 of a block's side in voxels
constexpr double kHalfDiagonal = 0.8660254037844387;

/// A node of the octree above the voxels and what it may have to do with: triangles that touch it,
/// and those that emit within half a voxel. In rising order.
struct Node {
    IVec3 low{0};  // grid units
    int level = 0;
    std::vector<uint32_t> touching;
    std::vector<uint32_t> glowing;

    int edge() const { return kGridUnits << level; }
};

IVec3 child_low(const IVec3& low, int level, int octant) {
    return low + IVec3(octant & 1, (octant >> 1) & 1, octant >> 2) * (kGridUnits << (level - 1));
}

bool is_near(const TriangleBox& triangle, const IVec3& low, int edge) {
    constexpr int kMargin = kGridUnits / 2;
    for (int axis = 0; axis < 3; ++axis) {
        if (triangle.high()[axis] < low[axis] - kMargin) return false;
        if (triangle.low()[axis] > low[axis] + edge + kMargin) return false;
    }
    return true;
}

/// The blocks that triangles touch, in Morton order.
class Blocks {
  public:
    Blocks(const GridMesh& grid, const MeshSurface& surface, int depth) : grid_(grid) {
        Node root{.level = depth};
        root.touching.resize(grid.triangles.size());
        std::iota(root.touching.begin(), root.touching.end(), uint32_t{0});
        for (const uint32_t i : root.touching) {
            if (surface.emits(grid.triangles[i])) root.glowing.push_back(i);
        }
        if (!root.touching.empty()) open_.push_back(std::move(root));
    }

    std::optional<Node> next() {
        while (!open_.empty()) {
            Node node = std::move(open_.back());
            open_.pop_back();
            if (node.level <= kBlockLevel) return node;
            split(node);
        }
        return std::nullopt;
    }

    uint64_t memory_bytes() const {
        uint64_t bytes = 0;
        for (const Node& node : open_) {
            bytes += (node.touching.capacity() + node.glowing.capacity()) * sizeof(uint32_t);
        }
        return bytes;
    }

  private:
    void split(const Node& node) {
        std::array<Node, 8> children;
        for (int octant = 0; octant < 8; ++octant) {
            Node& child = children[static_cast<size_t>(octant)];
            child.low = child_low(node.low, node.level, octant);
            child.level = node.level - 1;
        }
        for (const uint32_t i : node.touching) {
            const TriangleBox triangle(grid_.triangles[i].vertices);
            for (Node& child : children) {
                if (triangle.overlaps(child.low, child.edge())) child.touching.push_back(i);
            }
        }
        for (const uint32_t i : node.glowing) {
            const TriangleBox triangle(grid_.triangles[i].vertices);
            for (Node& child : children) {
                if (is_near(triangle, child.low, child.edge())) child.glowing.push_back(i);
            }
        }
        for (size_t i = children.size(); i-- > 0;) {
            if (!children[i].touching.empty()) open_.push_back(std::move(children[i]));
        }
    }

    const GridMesh& grid_;
    std::vector<Node> open_;  // the next one last
};

struct BlockVoxels {
    std::vector<Voxel> voxels;  // in Morton order
    double farthest = 0.0;      // of a voxel's middle from the surface, voxels
};

class Block {
  public:
    Block(const GridMesh& grid, const MeshSurface& surface, float emission_scale, const Node& node)
        : grid_(grid), surface_(surface), emission_scale_(emission_scale), node_(node) {
        for (const uint32_t i : node.touching) boxes_.emplace_back(grid.triangles[i].vertices);
        for (const uint32_t i : node.glowing) glow_boxes_.emplace_back(grid.triangles[i].vertices);
        List all;
        all.touching.resize(boxes_.size());
        std::iota(all.touching.begin(), all.touching.end(), uint32_t{0});
        all.glowing.resize(glow_boxes_.size());
        std::iota(all.glowing.begin(), all.glowing.end(), uint32_t{0});
        lists_[static_cast<size_t>(node.level)] = std::move(all);
    }

    BlockVoxels run() {
        descend(node_.low, node_.level);
        return std::move(result_);
    }

  private:
    /// Places in node_'s lists.
    struct List {
        std::vector<uint32_t> touching;
        std::vector<uint32_t> glowing;
    };

    void descend(const IVec3& low, int level) {
        const List& list = lists_[static_cast<size_t>(level)];
        if (level == 0) {
            add_voxel(low / kGridUnits, list);
            return;
        }
        List& below = lists_[static_cast<size_t>(level - 1)];
        const int edge = kGridUnits << (level - 1);
        for (int octant = 0; octant < 8; ++octant) {
            const IVec3 child = child_low(low, level, octant);
            below.touching.clear();
            for (const uint32_t i : list.touching) {
                if (boxes_[i].overlaps(child, edge)) below.touching.push_back(i);
            }
            if (below.touching.empty()) continue;
            below.glowing.clear();
            for (const uint32_t i : list.glowing) {
                if (is_near(glow_boxes_[i], child, edge)) below.glowing.push_back(i);
            }
            descend(child, level - 1);
        }
    }

    void add_voxel(const IVec3& position, const List& list) {
        touching_.clear();
        for (const uint32_t i : list.touching) touching_.push_back(node_.touching[i]);
        glowing_.clear();
        for (const uint32_t i : list.glowing) glowing_.push_back(node_.glowing[i]);
        const auto look = look_of(grid_, surface_, position, touching_, glowing_);
        if (!look) return;
        result_.farthest = std::max(result_.farthest, look->distance);
        result_.voxels.push_back(make_voxel(position, pack_rgb(look->albedo),
                                            pack_rgb(look->emission / emission_scale_)));
    }

    const GridMesh& grid_;
    const MeshSurface& surface_;
    float emission_scale_;
    const Node& node_;
    std::vector<TriangleBox> boxes_;
    std::vector<TriangleBox> glow_boxes_;
    std::array<List, kMaxDepth + 1> lists_;
    std::vector<uint32_t> touching_;
    std::vector<uint32_t> glowing_;
    BlockVoxels result_;
};

/// So that the brightest emission is some 2^14 when packed.
float emission_scale_for(float most) {
    return most > 0.0f ? std::ldexp(1.0f, std::ilogb(most) - 14) : 1.0f;
}

void check_size(const VoxeliseParams& params, uint64_t voxels, uint64_t bytes) {
    if (voxels > params.max_voxels) {
        throw std::invalid_argument("the mesh would become more than " +
                                    std::to_string(params.max_voxels) +
                                    " voxels; a larger voxel size makes fewer");
    }
    if (bytes > params.max_memory_bytes) {
        throw std::invalid_argument("making voxels of the mesh would take more than " +
                                    std::to_string(params.max_memory_bytes) +
                                    " bytes of memory; a larger voxel size takes less");
    }
}

}  // namespace

VoxelisedMesh voxelise(const TriangleMesh& mesh, const VoxeliseParams& params) {
    const auto start = std::chrono::steady_clock::now();
    const GridMesh grid = make_grid_mesh(mesh, params.voxel_size_m, params.corner_m);
    const MeshSurface surface(mesh, grid);
    const float emission_scale = emission_scale_for(surface.most_emission());
    const int depth = depth_for_extent(grid.extent);
    VoxelisedMesh made{
        .tree = {}, .surface = surface_triangles(mesh, grid), .corner_m = grid.corner_m};
    VoxeliseReport& report = made.report;

    TreeBuilder builder(depth);
    Blocks blocks(grid, surface, depth);
    const uint64_t fixed_bytes =
        grid.triangles.capacity() * sizeof(GridTriangle) + surface.memory_bytes();
    const auto at_once = static_cast<size_t>(4 * tbb::this_task_arena::max_concurrency());
    double farthest = 0.0;
    const auto next_block = [&](tbb::flow_control& control) {
        std::optional<Node> node = blocks.next();
        if (!node) control.stop();
        return node;
    };
    const auto make_block = [&](const std::optional<Node>& node) {
        return node ? Block(grid, surface, emission_scale, *node).run() : BlockVoxels{};
    };
    const auto append = [&](const BlockVoxels& block) {
        builder.append(block.voxels);
        farthest = std::max(farthest, block.farthest);
        const uint64_t block_bytes = at_once * block.voxels.capacity() * sizeof(Voxel);
        const uint64_t bytes = fixed_bytes + block_bytes + builder.memory_bytes();
        report.peak_bytes = std::max(report.peak_bytes, bytes);
        check_size(params, builder.voxel_count(), bytes);
    };
    tbb::parallel_pipeline(
        at_once,
        tbb::make_filter<void, std::optional<Node>>(tbb::filter_mode::serial_in_order, next_block) &
            tbb::make_filter<std::optional<Node>, BlockVoxels>(tbb::filter_mode::parallel,
                                                               make_block) &
            tbb::make_filter<BlockVoxels, void>(tbb::filter_mode::serial_in_order, append));
    made.tree = builder.finish(emission_scale);

    if (params.solid) {
        const uint64_t shell_bytes = made.tree.memory_bytes();
        SolidFill solid = fill_solid(std::move(made.tree), params.max_voxels);
        made.tree = std::move(solid.tree);
        report.filled_voxels = solid.filled;
        if (solid.filled > 0) {
            const uint64_t bytes = fixed_bytes + shell_bytes + made.tree.memory_bytes();
            report.peak_bytes = std::max(report.peak_bytes, bytes);
        }
    }
    report.triangles = grid.triangles.size();
    report.voxels = made.tree.voxel_count();
    report.peak_bytes = std::max(report.peak_bytes, fixed_bytes + made.tree.memory_bytes());
    report.voxel_diagonal_m = 2.0 * kHalfDiagonal * params.voxel_size_m;
    const PointCheck check = check_points(grid, surface, made.tree, params.checked_points);
    report.checked_points = check.points;
    report.uncovered_points = check.uncovered;
    report.hausdorff_m =
        check.uncovered > 0 ? kInfinity : (farthest + kHalfDiagonal) * params.voxel_size_m;
    if (report.voxels == 0) report.hausdorff_m = 0.0;
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return made;
}

}  // namespace probebake
