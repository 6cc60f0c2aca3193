// Media: what fills the air, as coefficients per channel times a density that varies in space.
//
//   absorption, scattering   1/m at density 1, per channel
//   emission                 W·m⁻²·sr⁻¹, of a source: a metre of medium emits absorption × emission
//                            (Kirchhoff); where nothing is absorbed, nothing is emitted
//   g                        Henyey-Greenstein
//
// Shapes: a homogeneous box, or everything; fog that thins out exponentially above a height; a
// DensityGrid placed by an affine map. Media overlap freely: their coefficients add up.
//
// Fog ends kFogScaleHeights above its base, where it is 4e-18 of it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "math/affine.h"
#include "volume/majorant_octree.h"
#include "volume/spectrum.h"

namespace probebake {

inline constexpr double kFogScaleHeights = 40.0;
inline constexpr size_t kMaxMedia = 8;

struct HomogeneousShape {
    std::optional<Box> box_m;  // none: everywhere
};

/// Density 1 at and below base_m, exp(−(y − base_m) / scale_height_m) above.
struct FogShape {
    double base_m = 0.0;
    double scale_height_m = 100.0;
    std::optional<Box> box_m;
};

struct GridShape {
    std::shared_ptr<const DensityGrid> density;
    Affine index_to_world;  // metres
    /// Multiplies the emission; in the same index space as the density. None: 1.
    std::shared_ptr<const DensityGrid> emission;
};

struct MediumSpec {
    std::string name;
    Rgb absorption_per_m{0.0f};
    Rgb scattering_per_m{0.0f};
    Rgb emission{0.0f};
    double g = 0.0;
    std::variant<HomogeneousShape, FogShape, GridShape> shape;
};

/// Throws std::invalid_argument that names medium and field for values that are negative, not
/// finite or out of range, for emission without absorption, and for a map that is not regular.
void check_medium(const MediumSpec& spec);

/// A medium ready for rays.
struct Medium {
    MediumSpec spec;
    Coefficients<3> unit;  // at density 1
    Spectrum<3> source;    // emission
    Box box;               // that holds it, metres; infinite sides where it has none
    // Of a grid:
    MajorantOctree octree;
    Affine world_to_index;
    Affine world_to_units;

    bool is_grid() const { return std::holds_alternative<GridShape>(spec.shape); }
    double density(const Vec3& position_m) const;
    double emission_scale(const Vec3& position_m) const;
    /// ∫ density dt, exact: 2-point Gauss in every trilinear cell, closed forms elsewhere.
    double column(const Ray& ray_m, const TRange& range) const;
};

class Media {
  public:
    Media() = default;
    /// Builds octrees; params.scale is set per medium. Throws as check_medium, and
    /// std::length_error beyond kMaxMedia.
    explicit Media(std::vector<MediumSpec> specs, const MajorantParams& params = {});

    const std::vector<Medium>& all() const { return media_; }
    bool empty() const { return media_.empty(); }
    /// Coefficients at a point, and what is emitted there per metre.
    Coefficients<3> at(const Vec3& position_m) const;
    Spectrum<3> emitted_per_m(const Vec3& position_m) const;
    /// Exact, per channel.
    Spectrum<3> optical_depth(const Ray& ray_m, const TRange& range) const;
    /// Of densities and octrees.
    uint64_t memory_bytes() const;

  private:
    std::vector<Medium> media_;
};

/// ∫ of the trilinear field along a ray in index space.
double grid_column(const DensityGrid& grid, const Ray& ray, const TRange& range);

}  // namespace probebake
