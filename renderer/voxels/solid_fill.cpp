#include "voxels/solid_fill.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "math/morton.h"
#include "voxels/tree_builder.h"

namespace probebake {
namespace {

constexpr size_t kVoxelsAtOnce = size_t{1} << 16;

/// An empty cube of 2^level voxels a side; `code` is the Morton code of its lowest voxel.
struct Cell {
    uint64_t code = 0;
    int level = 0;

    uint64_t voxels() const { return uint64_t{1} << (3 * level); }
};

/// The empty cells of a tree in Morton order, as large as its nodes have them.
class EmptyCells {
  public:
    explicit EmptyCells(const VoxelTree& tree) : tree_(tree) {
        visit(tree.node_levels() - 1, 0, 0, tree.depth() % 2 == 0 ? 8 : 1);
    }
    std::vector<Cell> take() { return std::move(cells_); }

  private:
    /// `code`: of the node at its own level. Of a root that is larger than the world only the first
    /// octant is in it.
    void visit(int k, uint32_t index, uint64_t code, uint32_t octants) {
        const VoxelNode& node = tree_.nodes()[index];
        for (uint32_t octant = 0; octant < octants; ++octant) {
            if ((node.mask >> (8 * octant) & 0xff) == 0) {
                add(code << 3 | octant, 2 * k + 1);
                continue;
            }
            for (uint32_t bit = 8 * octant; bit < 8 * octant + 8; ++bit) {
                const uint64_t cell = code << 6 | bit;
                if ((node.mask >> bit & 1) == 0) {
                    add(cell, 2 * k);
                } else if (k > 0) {
                    visit(k - 1, node.first_child + rank_below(node.mask, bit), cell, 8);
                }
            }
        }
    }
    void add(uint64_t code, int level) { cells_.push_back({code << (3 * level), level}); }

    const VoxelTree& tree_;
    std::vector<Cell> cells_;
};

/// Sets of cells that are connected; number 0 is what lies outside the world.
class Regions {
  public:
    explicit Regions(size_t count) : parents_(count) {
        std::iota(parents_.begin(), parents_.end(), uint32_t{0});
    }
    uint32_t find(uint32_t i) {
        while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
        return i;
    }
    void join(uint32_t a, uint32_t b) {
        a = find(a);
        b = find(b);
        parents_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<uint32_t> parents_;
};

/// The cell that holds a voxel and is no smaller than `level`, as a number from 1 on; 0 where there
/// is none.
uint32_t cell_at(const std::vector<Cell>& cells, uint64_t code, int level) {
    auto after = std::upper_bound(cells.begin(), cells.end(), code,
                                  [](uint64_t c, const Cell& cell) { return c < cell.code; });
    if (after == cells.begin()) return 0;
    const Cell& cell = *std::prev(after);
    if (cell.level < level || code - cell.code >= cell.voxels()) return 0;
    return static_cast<uint32_t>(after - cells.begin());
}

uint64_t code_of(const IVec3& p) {
    return morton_encode(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y),
                         static_cast<uint32_t>(p.z));
}

/// Cells that have no way out, in Morton order.
std::vector<Cell> inner_cells(const VoxelTree& tree) {
    const std::vector<Cell> cells = EmptyCells(tree).take();
    const int side = 1 << tree.depth();
    Regions regions(cells.size() + 1);
    for (size_t i = 0; i < cells.size(); ++i) {
        const auto own = static_cast<uint32_t>(i + 1);
        const IVec3 low = morton_decode(cells[i].code);
        for (int axis = 0; axis < 3; ++axis) {
            for (const int step : {-1, 1}) {
                IVec3 beside = low;
                beside[axis] += step * (1 << cells[i].level);
                if (beside[axis] < 0 || beside[axis] >= side) {
                    regions.join(own, 0);
                } else if (const uint32_t other = cell_at(cells, code_of(beside), cells[i].level)) {
                    regions.join(own, other);  // smaller ones join on their own account
                }
            }
        }
    }
    std::vector<Cell> inner;
    for (size_t i = 0; i < cells.size(); ++i) {
        if (regions.find(static_cast<uint32_t>(i + 1)) != 0) inner.push_back(cells[i]);
    }
    return inner;
}

}  // namespace

SolidFill fill_solid(VoxelTree tree, uint64_t max_voxels) {
    if (tree.empty()) return {std::move(tree), 0};
    const std::vector<Cell> inner = inner_cells(tree);
    uint64_t filled = 0;
    for (const Cell& cell : inner) filled += cell.voxels();
    if (filled == 0) return {std::move(tree), 0};
    if (tree.voxel_count() + filled > max_voxels) {
        throw std::invalid_argument("the filled mesh would have " +
                                    std::to_string(tree.voxel_count() + filled) +
                                    " voxels, expected at most " + std::to_string(max_voxels));
    }
    TreeBuilder builder(tree.depth());
    builder.reserve(tree.voxel_count() + filled);
    const ColorPyramid& colors = tree.colors();
    const bool emits = !colors.emission.empty();
    Voxel last{.albedo = colors.albedo.voxels.front()};
    auto cell = inner.begin();
    std::vector<Voxel> voxels;
    const auto fill_before = [&](uint64_t code) {
        for (; cell != inner.end() && cell->code < code; ++cell) {
            for (uint64_t c = cell->code; c < cell->code + cell->voxels(); ++c) {
                voxels.push_back({c << 16, last.albedo, 0});
                if (voxels.size() < kVoxelsAtOnce) continue;
                builder.append(voxels);
                voxels.clear();
            }
            builder.append(voxels);
            voxels.clear();
        }
    };
    size_t i = 0;
    tree.for_each_voxel([&](const IVec3& position) {
        fill_before(code_of(position));
        last = make_voxel(position, colors.albedo.voxels[i], emits ? colors.emission.voxels[i] : 0);
        builder.append({&last, 1});
        ++i;
    });
    fill_before(~uint64_t{0});
    return {builder.finish(emits ? colors.emission.scale : 1.0f), filled};
}

}  // namespace probebake
