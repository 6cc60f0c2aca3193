#include "voxels/filled_box.h"

namespace probebake {

Box filled_box(const VoxelTree& tree) {
    IVec3 low(1 << kMaxDepth);
    IVec3 high(0);
    tree.for_each_voxel([&](const IVec3& p) {
        low = glm::min(low, p);
        high = glm::max(high, p + 1);
    });
    return {Vec3(low), Vec3(high)};
}

}  // namespace probebake
