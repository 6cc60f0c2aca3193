#include "scene/generators/cumulus.h"

#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "math/random.h"
#include "scene/generators/noise.h"

namespace probebake {
namespace {

using worldgen::Noise;
using worldgen::Octaves;

struct Sphere {
    Vec3 center{0.0};
    double radius = 0.0;
};

/// Unit cube, y up, base at 0.28.
std::vector<Sphere> make_heap(const CumulusParams& params) {
    RandomStream random(random_key({params.seed, 0xC10D}));
    const auto between = [&](double a, double b) { return a + (b - a) * random.uniform(); };
    std::vector<Sphere> heap;
    heap.push_back({{0.5, 0.42, 0.5}, 0.17});
    while (static_cast<int>(heap.size()) < params.spheres) {
        const Sphere& on = heap[random.below(heap.size())];
        const double radius = on.radius * between(0.45, 0.85);
        if (radius < 0.03) continue;
        const double x = between(-1.0, 1.0);
        const double y = between(-0.25, 1.0);
        const double z = between(-1.0, 1.0);
        const double length = std::sqrt(x * x + y * y + z * z);
        if (!(length > 0.1 && length < 1.0)) continue;
        const Vec3 center = on.center + Vec3(x, y, z) / length * on.radius;
        const Vec3 from_middle = glm::abs(center - Vec3(0.5));
        if (std::max({from_middle.x, from_middle.y, from_middle.z}) + radius > 0.42) continue;
        heap.push_back({center, radius});
    }
    return heap;
}

float round_to_half(double value) {
    const auto narrow = static_cast<float>(value);
    if (narrow < 0x1.0p-14f) return 0.0f;
    return std::bit_cast<float>((std::bit_cast<uint32_t>(narrow) + 0x1000u) & ~0x1FFFu);
}

class Cloud {
  public:
    explicit Cloud(const CumulusParams& params)
        : params_(params),
          heap_(make_heap(params)),
          shape_noise_(random_key({params.seed, 1})),
          inner_noise_(random_key({params.seed, 2})) {}

    /// Signed distance to the heap, flat below the base.
    double distance(const Vec3& p) const {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Sphere& sphere : heap_) {
            nearest = std::min(nearest, glm::length(p - sphere.center) - sphere.radius);
        }
        return std::max(nearest, 0.3 - p.y);
    }

    double density(const Vec3& p) const {
        const double d = distance(p);
        if (d > params_.displacement) return 0.0;
        double depth = -d / params_.edge;
        if (d > -params_.displacement - params_.edge) {
            const double bumps = std::clamp(
                shape_noise_.fbm(p, Octaves{.wavelength_m = 0.09, .count = 4}) * 1.5, -1.0, 1.0);
            depth += bumps * params_.displacement / params_.edge;
        }
        if (depth <= 0.0) return 0.0;
        const double inner =
            std::clamp(inner_noise_.fbm(p, Octaves{.wavelength_m = 0.05, .count = 1}), -1.0, 1.0);
        return worldgen::smooth_step(0.0, 1.0, depth) * (0.67 + 0.33 * inner);
    }

  private:
    CumulusParams params_;
    std::vector<Sphere> heap_;
    Noise shape_noise_;
    Noise inner_noise_;
};

}  // namespace

DensityGrid make_cumulus(const CumulusParams& params) {
    if (params.size < 16 || params.size > 4096 || params.spheres < 1 || params.spheres > 1000 ||
        !(params.edge > 0.0) || !(params.displacement >= 0.0) || !(params.displacement < 0.08)) {
        throw std::invalid_argument("cumulus: parameters out of range");
    }
    const Cloud cloud(params);
    const double scale = 1.0 / params.size;
    const double brick_radius = 0.5 * std::sqrt(3.0) * DensityGrid::kBrick * scale;
    const DensityGrid::BuildParams extent{IVec3(0), IVec3(params.size - 1)};
    return DensityGrid(extent, [&](const IVec3& low, DensityGrid::BrickValues values) {
        const Vec3 middle = (Vec3(low) + 0.5 * DensityGrid::kBrick) * scale;
        if (cloud.distance(middle) > params.displacement + brick_radius) return false;
        size_t i = 0;
        for (int z = 0; z < DensityGrid::kSide; ++z) {
            for (int y = 0; y < DensityGrid::kSide; ++y) {
                for (int x = 0; x < DensityGrid::kSide; ++x) {
                    values[i++] = round_to_half(cloud.density(Vec3(low + IVec3(x, y, z)) * scale));
                }
            }
        }
        return true;
    });
}

}  // namespace probebake
