#include "octree/item_octree.h"

#include <bit>
#include <numeric>
#include <stdexcept>
#include <string>

namespace probebake {
namespace {

/// The octants that a closed box touches, as a mask.
uint32_t touched_octants(const Box& item, const Vec3& planes) {
    uint32_t octants = 0xFF;
    constexpr uint32_t kBelow[3] = {0x55, 0x33, 0x0F};
    for (int axis = 0; axis < 3; ++axis) {
        if (!(item.low[axis] <= planes[axis])) octants &= ~kBelow[axis];
        if (!(item.high[axis] >= planes[axis])) octants &= kBelow[axis];
    }
    return octants;
}

class Builder {
  public:
    Builder(std::span<const Box> item_boxes, const ItemOctreeParams& params, Octree& tree,
            std::vector<uint32_t>& items, std::vector<uint32_t>& leaf_begin)
        : item_boxes_(item_boxes),
          params_(params),
          tree_(tree),
          items_(items),
          leaf_begin_(leaf_begin) {}

    OctreeRef build(const Box& box, std::span<const uint32_t> items, int depth) {
        if (items.size() <= params_.most_items || depth >= params_.max_depth ||
            items_.size() + items.size() > params_.most_references) {
            return make_leaf(items);
        }
        const Vec3 planes = params_.planes == SplitPlanes::kCenter
                                ? center_planes(box)
                                : cost_planes(box, items, item_boxes_);
        const OctreeRef ref = tree_.add_node(planes);
        std::array<std::vector<uint32_t>, 8> parts;
        for (const uint32_t item : items) {
            uint32_t octants = touched_octants(item_boxes_[item], planes);
            for (; octants != 0; octants &= octants - 1) {
                parts[static_cast<size_t>(std::countr_zero(octants))].push_back(item);
            }
        }
        for (int octant = 0; octant < 8; ++octant) {
            std::vector<uint32_t>& part = parts[static_cast<size_t>(octant)];
            tree_.set_child(ref, octant, build(octant_box(box, planes, octant), part, depth + 1));
            part = {};
        }
        return ref;
    }
    uint64_t empty_leaves() const { return empty_leaves_; }

  private:
    OctreeRef make_leaf(std::span<const uint32_t> items) {
        if (items.empty()) {
            ++empty_leaves_;
            return OctreeRef::empty_leaf();
        }
        constexpr size_t kMost = size_t{1} << 32;  // leaf_begin is 32 bits wide
        if (items_.size() + items.size() >= kMost)
            throw std::length_error("octree: too many items");
        items_.insert(items_.end(), items.begin(), items.end());
        leaf_begin_.push_back(static_cast<uint32_t>(items_.size()));
        return OctreeRef::leaf(static_cast<uint32_t>(leaf_begin_.size() - 2));
    }

    std::span<const Box> item_boxes_;
    const ItemOctreeParams& params_;
    Octree& tree_;
    std::vector<uint32_t>& items_;
    std::vector<uint32_t>& leaf_begin_;
    uint64_t empty_leaves_ = 0;
};

void check(const Box& root, std::span<const Box> item_boxes, const ItemOctreeParams& params) {
    if (params.max_depth < 0 || params.max_depth > kMaxOctreeDepth) {
        throw std::invalid_argument("octree: depth " + std::to_string(params.max_depth) +
                                    "; expected 0 to " + std::to_string(kMaxOctreeDepth));
    }
    constexpr uint64_t kMostReferences = uint64_t{1} << 31;
    if (item_boxes.size() > params.most_references || params.most_references > kMostReferences) {
        throw std::invalid_argument("octree: too many items, " + std::to_string(item_boxes.size()));
    }
    const auto finite = [](const Box& box) { return is_finite(box.low) && is_finite(box.high); };
    if (!finite(root)) throw std::invalid_argument("octree: a box that is not finite");
    for (const Box& box : item_boxes) {
        if (!finite(box)) throw std::invalid_argument("octree: a box that is not finite");
    }
}

}  // namespace

ItemOctree::ItemOctree(const Box& root, std::span<const Box> item_boxes,
                       const ItemOctreeParams& params)
    : tree_(root) {
    check(root, item_boxes, params);
    std::vector<uint32_t> all(item_boxes.size());
    std::iota(all.begin(), all.end(), uint32_t{0});
    Builder builder(item_boxes, params, tree_, items_, leaf_begin_);
    tree_.set_root(builder.build(root, all, 0));
    counts_ = {.inner = tree_.nodes().size(),
               .leaves = 7 * tree_.nodes().size() + 1,
               .empty_leaves = builder.empty_leaves(),
               .references = items_.size()};
}

uint64_t ItemOctree::memory_bytes() const {
    return tree_.nodes().size() * sizeof(Octree::Node) + items_.size() * sizeof(uint32_t) +
           leaf_begin_.size() * sizeof(uint32_t);
}

}  // namespace probebake
