#include "octree/octree.h"

#include <stdexcept>

namespace probebake {

OctreeRef Octree::add_node(const Vec3& planes) {
    constexpr size_t kMostNodes = size_t{1} << 31;
    if (nodes_.size() + 1 >= kMostNodes) throw std::length_error("octree: too many nodes");
    nodes_.push_back({planes, {}});
    return OctreeRef::node(static_cast<uint32_t>(nodes_.size() - 1));
}

Box octant_box(const Box& box, const Vec3& planes, int octant) {
    Box part = box;
    for (int axis = 0; axis < 3; ++axis) {
        const bool above = ((octant >> axis) & 1) != 0;
        (above ? part.low : part.high)[axis] = planes[axis];
    }
    return part;
}

}  // namespace probebake
