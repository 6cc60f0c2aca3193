#include "scene/scene.h"

#include <algorithm>
#include <cmath>

namespace probebake {

double Scene::reach_m(const Vec3& position_m) const {
    const Vec3 p = to_voxels(position_m);
    const double side = std::ldexp(1.0, tree.depth());
    const Vec3 farthest(std::max(std::abs(p.x), std::abs(side - p.x)),
                        std::max(std::abs(p.y), std::abs(side - p.y)),
                        std::max(std::abs(p.z), std::abs(side - p.z)));
    return glm::length(farthest) * voxel_size_m;
}

bool Scene::inside_voxel(const Vec3& position_m) const {
    const Vec3 p = glm::floor(to_voxels(position_m));
    const double side = std::ldexp(1.0, tree.depth());
    for (int axis = 0; axis < 3; ++axis) {
        if (!(p[axis] >= 0.0 && p[axis] < side)) return false;
    }
    return tree.occupied(IVec3(p));
}

}  // namespace probebake
