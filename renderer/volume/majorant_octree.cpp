#include "volume/majorant_octree.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace probebake {
namespace {

using Bounds = DensityGrid::Bounds;

Bounds join(const Bounds& a, const Bounds& b) {
    return {std::min(a.least, b.least), std::max(a.most, b.most)};
}

/// Bounds of 2^k bricks per side, k = 0 for single ones.
class BrickPyramid {
  public:
    BrickPyramid(const DensityGrid& grid, int levels) {
        levels_.push_back(
            make_level(grid.bricks(), [&](const IVec3& at) { return grid.brick_bounds(at); }));
        for (int k = 1; k < levels; ++k) {
            const Level& below = levels_.back();
            levels_.push_back(make_level((below.size + 1) / 2, [&](const IVec3& at) {
                Bounds bounds = below.at(at * 2);
                for (int child = 1; child < 8; ++child) {
                    const IVec3 c = at * 2 + IVec3(child & 1, child >> 1 & 1, child >> 2);
                    if (glm::all(glm::lessThan(c, below.size))) bounds = join(bounds, below.at(c));
                }
                return bounds;
            }));
        }
    }
    Bounds at(int level, const IVec3& brick) const {
        return levels_[static_cast<size_t>(level)].at(brick);
    }

  private:
    struct Level {
        IVec3 size{0};
        std::vector<Bounds> bounds;

        const Bounds& at(const IVec3& i) const {
            return bounds[(static_cast<size_t>(i.z) * static_cast<size_t>(size.y) +
                           static_cast<size_t>(i.y)) *
                              static_cast<size_t>(size.x) +
                          static_cast<size_t>(i.x)];
        }
    };

    template <class Make>
    static Level make_level(const IVec3& size, Make make) {
        const auto nx = static_cast<size_t>(size.x);
        const auto ny = static_cast<size_t>(size.y);
        Level level{size, std::vector<Bounds>(nx * ny * static_cast<size_t>(size.z))};
        tbb::parallel_for(size_t{0}, level.bounds.size(), [&](size_t i) {
            level.bounds[i] = make(IVec3(static_cast<int>(i % nx), static_cast<int>(i / nx % ny),
                                         static_cast<int>(i / (nx * ny))));
        });
        return level;
    }

    std::vector<Level> levels_;
};

/// A node under way: its place in units of its own edge.
struct Place {
    IVec3 at{0};
    uint32_t node = 0;
};

class Builder {
  public:
    Builder(const DensityGrid& grid, int root_log2)
        : grid_(grid), root_log2_(root_log2), pyramid_(grid, std::max(1, root_log2 - 2)) {}

    /// False where the node lies outside the grid's cells.
    bool inside(int level, const IVec3& at) const {
        const double edge = std::ldexp(1.0, root_log2_ - level);
        return glm::all(glm::lessThan(Vec3(at) * edge, Vec3(grid_.cells())));
    }

    Bounds bounds(int level, const IVec3& at) const {
        const int log2_edge = root_log2_ - level;
        if (log2_edge >= 3) return pyramid_.at(log2_edge - 3, at);
        if (log2_edge >= 0) {
            const IVec3 low = at * (1 << log2_edge);
            const IVec3 high = glm::min(low + (1 << log2_edge), grid_.cells());
            return grid_.bounds_in_brick(grid_.low() + low, grid_.low() + high);
        }
        return within_cell(std::ldexp(1.0, log2_edge), at);
    }

  private:
    Bounds within_cell(double edge, const IVec3& at) const {
        const IVec3 cell(Vec3(at) * edge);
        const Vec3 low = Vec3(at) * edge - Vec3(cell);
        std::array<double, 8> corner{};
        for (int i = 0; i < 8; ++i) {
            corner[static_cast<size_t>(i)] =
                double{grid_.value(grid_.low() + cell + IVec3(i & 1, i >> 1 & 1, i >> 2))};
        }
        double least = std::numeric_limits<double>::infinity();
        double most = 0.0;
        for (int i = 0; i < 8; ++i) {
            const Vec3 f = low + Vec3(i & 1, i >> 1 & 1, i >> 2) * edge;
            double sum = 0.0;
            for (int k = 0; k < 8; ++k) {
                sum += corner[static_cast<size_t>(k)] * ((k & 1) != 0 ? f.x : 1.0 - f.x) *
                       ((k & 2) != 0 ? f.y : 1.0 - f.y) * ((k & 4) != 0 ? f.z : 1.0 - f.z);
            }
            least = std::min(least, sum);
            most = std::max(most, sum);
        }
        // Rounded outwards, so that they stay bounds in float.
        const auto down = static_cast<float>(least * (1.0 - 1e-6));
        const auto up = static_cast<float>(most * (1.0 + 1e-6));
        return {down, up};
    }

    const DensityGrid& grid_;
    int root_log2_;
    BrickPyramid pyramid_;
};

void check(const MajorantParams& params) {
    if (params.max_depth < 1 || params.max_depth > kMaxMajorantDepth) {
        throw std::invalid_argument("majorant octree: depth " + std::to_string(params.max_depth) +
                                    "; expected 1 to " + std::to_string(kMaxMajorantDepth));
    }
    if (!(params.threshold > 0.0) || !(params.scale > 0.0) || !std::isfinite(params.scale)) {
        throw std::invalid_argument("majorant octree: threshold and scale must be positive");
    }
}

}  // namespace

MajorantOctree::MajorantOctree(const DensityGrid& grid, const MajorantParams& params) {
    check(params);
    const IVec3& cells = grid.cells();
    const int longest = std::max({cells.x, cells.y, cells.z});
    const int root_log2 = static_cast<int>(std::bit_width(static_cast<unsigned>(longest - 1)));
    levels_ = params.max_depth - 1;
    const double per_cell = std::ldexp(1.0, levels_ - root_log2);
    index_to_units_.linear = glm::dmat3(per_cell);
    index_to_units_.offset = -per_cell * Vec3(grid.low());
    box_units_ = {Vec3(0.0), per_cell * Vec3(cells)};

    const Builder builder(grid, root_log2);
    const Bounds root = builder.bounds(0, IVec3(0));
    nodes_.push_back({0, root.least, root.most});
    std::vector<Place> level_nodes{{IVec3(0), 0}};
    double most_sum = 0.0;
    double residual_sum = 0.0;
    for (int level = 0; !level_nodes.empty(); ++level) {
        depth_reached_ = level + 1;
        const double edge = std::ldexp(1.0, root_log2 - level);
        const auto wants_split = [&](const Node& node) {
            const double residual = double{node.most} - double{node.least};
            return residual * edge * params.scale > params.threshold;
        };
        const auto wishes = static_cast<uint64_t>(
            std::count_if(level_nodes.begin(), level_nodes.end(),
                          [&](const Place& place) { return wants_split(nodes_[place.node]); }));
        const bool goes_on = level < levels_ && nodes_.size() + 8 * wishes <= params.most_nodes;
        std::vector<Place> split;
        for (const Place& place : level_nodes) {
            const Node& node = nodes_[place.node];
            const double residual = double{node.most} - double{node.least};
            if (goes_on && wants_split(node)) {
                split.push_back(place);
            } else {
                const double volume = edge * edge * edge;
                most_sum += double{node.most} * volume;
                residual_sum += residual * volume;
            }
        }
        const size_t base = nodes_.size();
        nodes_.resize(base + split.size() * 8);
        level_nodes.assign(split.size() * 8, {});
        tbb::parallel_for(size_t{0}, split.size(), [&](size_t i) {
            const size_t first = base + i * 8;
            nodes_[split[i].node].first_child = static_cast<uint32_t>(first);
            for (size_t child = 0; child < 8; ++child) {
                const auto c = static_cast<int>(child);
                const IVec3 at = split[i].at * 2 + IVec3(c & 1, c >> 1 & 1, c >> 2);
                Bounds bounds;
                if (builder.inside(level + 1, at)) bounds = builder.bounds(level + 1, at);
                nodes_[first + child] = {0, bounds.least, bounds.most};
                level_nodes[i * 8 + child] = {at, static_cast<uint32_t>(first + child)};
            }
        });
    }
    residual_share_ = most_sum > 0.0 ? residual_sum / most_sum : 0.0;
}

OctreeWalk::OctreeWalk(const MajorantOctree& tree, const Ray& ray, const TRange& range)
    : tree_(&tree), origin_(ray.origin), direction_(safe_direction(ray.direction)) {
    inverse_ = 1.0 / direction_;
    const auto inside = clip(tree.box_units(), {origin_, direction_}, range);
    if (!inside) return;
    t_ = inside->begin;
    end_ = inside->end;
    const int last = (1 << tree.levels()) - 1;
    const Vec3 at = origin_ + direction_ * t_;
    for (int axis = 0; axis < 3; ++axis) {
        const double farthest = last;
        cell_[axis] = static_cast<int>(std::clamp(at[axis], 0.0, farthest));
    }
}

bool OctreeWalk::next(DensitySegment& segment) {
    if (!(t_ < end_)) return false;
    const std::vector<MajorantOctree::Node>& nodes = tree_->nodes();
    const int levels = tree_->levels();
    const MajorantOctree::Node* node = &nodes[path_[static_cast<size_t>(level_)]];
    while (node->first_child != 0) {
        const int shift = levels - 1 - level_;
        const int child =
            (cell_.x >> shift & 1) | (cell_.y >> shift & 1) << 1 | (cell_.z >> shift & 1) << 2;
        const uint32_t index = node->first_child + static_cast<uint32_t>(child);
        path_[static_cast<size_t>(++level_)] = index;
        node = &nodes[index];
    }
    const int edge = 1 << (levels - level_);
    const IVec3 low(cell_.x & -edge, cell_.y & -edge, cell_.z & -edge);
    int axis = 0;
    double t1 = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
        const int plane = direction_[a] > 0.0 ? low[a] + edge : low[a];
        const double t = (plane - origin_[a]) * inverse_[a];
        if (t < t1) {
            t1 = t;
            axis = a;
        }
    }
    t1 = std::max(t1, t_);
    segment = {t_, std::min(t1, end_), double{node->least}, double{node->most}};
    t_ = t1;

    IVec3 to = cell_;
    const Vec3 at = origin_ + direction_ * t1;
    for (int a = 0; a < 3; ++a) {
        to[a] = a != axis ? std::clamp(static_cast<int>(std::clamp(at[a], -1.0, 65536.0)), low[a],
                                       low[a] + edge - 1)
                          : (direction_[a] > 0.0 ? low[a] + edge : low[a] - 1);
    }
    if (to[axis] < 0 || to[axis] >= 1 << levels) {
        t_ = end_;
        return true;
    }
    const auto differ =
        static_cast<unsigned>((to.x ^ cell_.x) | (to.y ^ cell_.y) | (to.z ^ cell_.z));
    level_ = std::min(level_, levels - static_cast<int>(std::bit_width(differ)));
    cell_ = to;
    return true;
}

}  // namespace probebake
