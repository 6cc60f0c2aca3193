// SkyLight: the light of a sky on the six face directions, cut into directions of equal energy.
//
// Per face direction the hemisphere above it is a grid of 64 × 64 cells of equal projected solid
// angle (the square mapped onto the unit disc, Shirley and Chiu 1997; the disc lifted onto the
// hemisphere), each holding ∫ L cos dω. In Morton order the cells are cut into n strata of equal
// energy, so that a bright spot gets the rays that it deserves and a constant sky n compact
// patches. Irradiance = Σ weight · visibility, one random direction per stratum, drawn by energy:
// without anything in the way it is exact, whatever the sky; a sun in a picture blurs to a cell,
// about 2°.
#pragma once

#include <array>
#include <vector>

#include "light/sky.h"
#include "math/cube_face.h"
#include "math/random.h"

namespace probebake {

class SkyLight {
  public:
    /// n ≥ 1 strata. Pictures are integrated over all their texels.
    SkyLight(const Sky& sky, int strata);

    bool black() const { return black_; }
    int strata() const { return strata_; }
    /// ∫ L cos dω over the hemisphere above the face: irradiance without anything in the way.
    const Vec3& irradiance(CubeFace face) const { return at(face).total; }
    /// The part of it that comes through a stratum.
    const Vec3& weight(CubeFace face, int stratum) const {
        return at(face).weights[static_cast<size_t>(stratum)];
    }
    /// A unit direction of the stratum, strictly above the face.
    Vec3 direction(CubeFace face, int stratum, RandomStream& random) const;

    static constexpr int kGrid = 64;
    static constexpr size_t kCells = size_t{kGrid} * kGrid;

  private:
    struct Hemisphere {
        Vec3 total{0.0};
        std::vector<double> cumulative;  // energy of the cells up to and with this one
        std::vector<Vec3> weights;       // per stratum
    };
    const Hemisphere& at(CubeFace face) const { return faces_[static_cast<size_t>(face)]; }
    void cut(Hemisphere& hemisphere, const std::vector<Vec3>& cells) const;

    int strata_ = 1;
    bool black_ = true;
    std::array<Hemisphere, kFaceCount> faces_;
};

/// Unit direction above a face for a point of the unit square, its density proportional to the
/// cosine; and back: requires a direction above the face.
Vec3 cosine_direction(CubeFace face, const Vec2& square);
Vec2 cosine_square(CubeFace face, const Vec3& direction);

}  // namespace probebake
