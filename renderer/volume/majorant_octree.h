// MajorantOctree: bounds of a DensityGrid in the boxes of an octree, and the walk of a ray through
// its leaves (Kutz et al. 2017, supplemental 2.5).
//
// The root is the smallest cube of 2^k cells at the grid's lowest lattice point that holds the
// grid; depth 1 is the root alone, depth d has up to 2^(d−1) leaves per side, below the cells where
// d − 1 > k. Bounds are exact, not estimates: a trilinear field takes its extremes over a box of
// cells at lattice points, and over a box within one cell at the box's corners. A leaf is split
// while (most − least) · edge · scale exceeds the threshold: the optical thickness that its null
// collisions would have. Children stand in a row: x + 2y + 4z.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/affine.h"
#include "volume/density_grid.h"

namespace probebake {

struct MajorantParams {
    int max_depth = 8;  // 1..16
    double threshold = 0.5;
    /// Optical thickness per unit of density and per cell: largest extinction × metres per cell.
    double scale = 1.0;
    /// No level is begun that would make more nodes than this (12 bytes each): thick media ask for
    /// leaves far below the cells, without end.
    uint64_t most_nodes = uint64_t{1} << 24;
};
inline constexpr int kMaxMajorantDepth = 16;

/// Where a ray meets what, in the octree's units: its finest leaves have edge 1.
struct DensitySegment {
    double t0;
    double t1;
    double least;
    double most;
};

class MajorantOctree {
  public:
    struct Node {
        uint32_t first_child = 0;  // 0: a leaf
        float least = 0.0f;
        float most = 0.0f;

        bool operator==(const Node&) const = default;
    };

    MajorantOctree() = default;
    /// In parallel on the calling arena, the same for any number of threads. Throws
    /// std::invalid_argument for a depth out of range or a threshold or scale that is not finite
    /// and positive.
    MajorantOctree(const DensityGrid& grid, const MajorantParams& params);

    const std::vector<Node>& nodes() const { return nodes_; }
    /// Levels below the root that there may be: depth − 1.
    int levels() const { return levels_; }
    /// Levels that are really there, the root included.
    int depth_reached() const { return depth_reached_; }
    uint64_t leaf_count() const { return nodes_.empty() ? 0 : 1 + (nodes_.size() - 1) / 8 * 7; }
    uint64_t memory_bytes() const { return nodes_.size() * sizeof(Node); }

    /// From the grid's index space to units of the finest leaves.
    const Affine& index_to_units() const { return index_to_units_; }
    /// The grid's box of cells, in those units.
    const Box& box_units() const { return box_units_; }
    /// Share of the box's majorant that is no minorant: ∫(most − least) / ∫ most over the leaves.
    double residual_share() const { return residual_share_; }

  private:
    std::vector<Node> nodes_;
    int levels_ = 0;
    int depth_reached_ = 0;
    Affine index_to_units_;
    Box box_units_;
    double residual_share_ = 0.0;
};

/// The leaves along a ray, front to back; neighbours share their t. Cells are walked by their
/// integer coordinates: nothing is advanced by an epsilon, every step goes on to another leaf.
class OctreeWalk {
  public:
    /// No leaves.
    OctreeWalk() = default;
    /// `ray` in units of the finest leaves, any length of direction (t keeps its meaning).
    OctreeWalk(const MajorantOctree& tree, const Ray& ray, const TRange& range);

    /// False where there is no leaf left.
    bool next(DensitySegment& segment);

  private:
    const MajorantOctree* tree_ = nullptr;
    Vec3 origin_{0.0};
    Vec3 direction_{1.0};
    Vec3 inverse_{1.0};
    double t_ = 0.0;
    double end_ = 0.0;
    IVec3 cell_{0};
    int level_ = 0;  // of the deepest node known to hold cell_; 0: the root
    std::array<uint32_t, kMaxMajorantDepth> path_{};
};

}  // namespace probebake
