#include "scene/generators/random.h"

#include <cmath>

namespace probebake::worldgen {

Vec3 random_azimuth(RandomStream& random) {
    for (;;) {
        const double x = 2.0 * random.uniform() - 1.0;
        const double z = 2.0 * random.uniform() - 1.0;
        const double r2 = x * x + z * z;
        if (r2 > 1.0 || r2 < 0.01) continue;
        const double r = std::sqrt(r2);
        return {x / r, 0.0, z / r};
    }
}

double between(RandomStream& random, double from, double to) {
    return from + (to - from) * random.uniform();
}

Vec3 random_offset(RandomStream& random, double from, double to) {
    const Vec3 azimuth = random_azimuth(random);
    return azimuth * between(random, from, to);
}

}  // namespace probebake::worldgen
