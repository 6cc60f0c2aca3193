// What the generators draw with: voxels from points, lines, blobs and boxes given in metres.
//
// A canvas collects the voxels of one task. Overlaps are settled by the paint's layer, later by
// colour, never by the order of drawing (voxel_cloud.h), so tasks need not know of each other. What
// falls outside the world, or below the ground's shell, is left out. Strokes thinner than a voxel
// are one voxel thick.
#pragma once

#include <cstdint>
#include <vector>

#include "math/random.h"
#include "scene/generators/ground.h"
#include "voxels/voxel_cloud.h"

namespace probebake::worldgen {

inline constexpr Vec3 kUp{0.0, 1.0, 0.0};

/// Who wins where things overlap: the higher one.
enum class Layer : uint16_t { kGround, kLitter, kRock, kWood, kLeaf, kBuilding, kLight };

struct Paint {
    Rgb color{0.5f};     // linear reflectance
    double grain = 0.1;  // spread of single voxels' brightness, ± relative
    Layer layer = Layer::kBuilding;
    Rgb emission{0.0f};  // radiance, W·m⁻²·sr⁻¹
};

/// Leaves or needles in the shape of an ellipsoid.
struct Foliage {
    Rgb color{0.05f, 0.1f, 0.03f};
    double density_per_m = 1.4;  // leaf area per volume: its product with the voxel's edge is the
                                 // share of voxels that hold a leaf
    double snow = 0.0;           // share of the upper voxels that carry snow
    Layer layer = Layer::kLeaf;
};

/// Reflectances stay within what natural surfaces have.
Rgb natural_albedo(const Rgb& color);

class Canvas {
  public:
    /// `ground` may be null: nothing is hidden then. `key` seeds the grain.
    Canvas(int size, double voxel_m, const Ground* ground, uint64_t key)
        : size_(size), voxel_m_(voxel_m), ground_(ground), key_(key) {}

    int size() const { return size_; }
    double voxel_m() const { return voxel_m_; }
    const Ground& ground() const { return *ground_; }
    /// Whether a detail of this size can be told from its surroundings.
    bool resolves(double size_m) const { return size_m >= 0.5 * voxel_m_; }
    IVec3 voxel_at(const Vec3& at_m) const { return IVec3(glm::floor(at_m / voxel_m_)); }
    Vec3 center_m(const IVec3& voxel) const { return (Vec3(voxel) + 0.5) * voxel_m_; }
    /// Uniform in [0, 1), a function of the voxel's position.
    double hash(const IVec3& voxel) const;

    void put(const IVec3& voxel, const Paint& paint);
    /// A voxel of the ground itself, in exactly this colour.
    void put_ground(const IVec3& voxel, const Rgb& albedo);
    /// A straight limb, round, from one radius to another.
    void limb(const Vec3& from_m, const Vec3& to_m, const Vec2& radii_m, const Paint& paint);
    /// All voxels whose centres lie in [lo, hi), at least one thick.
    void box(const Vec3& lo_m, const Vec3& hi_m, const Paint& paint);
    void foliage(const Vec3& center_m, const Vec3& radii_m, const Foliage& foliage, uint64_t key);

    std::vector<Voxel> take() { return std::move(voxels_); }
    /// All that was drawn, as a world.
    VoxelCloud take_cloud() { return {take(), 1.0f, depth_for_extent(IVec3(size_))}; }

  private:
    bool hidden(const IVec3& voxel) const;

    int size_;
    double voxel_m_;
    const Ground* ground_;
    uint64_t key_;
    std::vector<Voxel> voxels_;
};

}  // namespace probebake::worldgen
