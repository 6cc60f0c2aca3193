// The 48 symmetries of the cube, acting on directions and on child masks.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "math/vec.h"

namespace probebake::test {

/// Component a of the image is sign[a] times component axis[a] of the original.
struct CubeSymmetry {
    std::array<int, 3> axis{0, 1, 2};
    Vec3 sign{1.0};

    Vec3 operator()(const Vec3& v) const { return sign * Vec3(v[axis[0]], v[axis[1]], v[axis[2]]); }
    uint8_t operator()(uint8_t mask) const {
        unsigned image = 0;
        for (int octant = 0; octant < 8; ++octant) {
            if ((mask >> octant & 1) == 0) continue;
            const Vec3 center = (*this)(Vec3((octant & 1) != 0 ? 1 : -1, (octant & 2) != 0 ? 1 : -1,
                                             (octant & 4) != 0 ? 1 : -1));
            image |=
                1u << ((center.x > 0 ? 1 : 0) + (center.y > 0 ? 2 : 0) + (center.z > 0 ? 4 : 0));
        }
        return static_cast<uint8_t>(image);
    }
};

inline std::vector<CubeSymmetry> cube_symmetries() {
    std::vector<CubeSymmetry> all;
    CubeSymmetry s;
    do {
        for (int signs = 0; signs < 8; ++signs) {
            s.sign = {(signs & 1) != 0 ? -1 : 1, (signs & 2) != 0 ? -1 : 1,
                      (signs & 4) != 0 ? -1 : 1};
            all.push_back(s);
        }
    } while (std::next_permutation(s.axis.begin(), s.axis.end()));
    return all;
}

/// Unit directions at which tables break: axes, planes, diagonals, all but vanishing components.
inline std::vector<Vec3> awkward_directions() {
    std::vector<Vec3> all;
    for (const Vec3& d : {Vec3(1, 0, 0),           Vec3(0, 1, 0),
                          Vec3(0, 0, 1),           Vec3(1, 1, 0),
                          Vec3(0, 1, 1),           Vec3(1, 0, 1),
                          Vec3(1, 1, 1),           Vec3(1, 1, 2),
                          Vec3(1, 2, 0),           Vec3(3, 4, 0),
                          Vec3(1, 1e-9, 0),        Vec3(1, 1e-9, 1e-9),
                          Vec3(1, 1, 1e-12),       Vec3(1e-17, 1, 1e-16),
                          Vec3(1e-17, 1e-17, 1),   Vec3(1, 1e-170, 1e-190),
                          Vec3(1, 1e-199, 1e-201), Vec3(1, 1e-300, 1),
                          Vec3(5e-324, 1, 5e-324), Vec3(-3e-323, 1, 1e-323),
                          Vec3(1e-160, 5e-324, 1)}) {
        all.push_back(glm::normalize(d));
        all.push_back(glm::normalize(Vec3(-d.x, d.y, -d.z)));  // negative zeros too
    }
    return all;
}

}  // namespace probebake::test
