// Colours of bare and covered ground, with texture from metres down to single voxels.
#pragma once

#include "scene/generators/landscape.h"
#include "scene/generators/noise.h"

namespace probebake::worldgen {

class Soil {
  public:
    explicit Soil(uint64_t seed);

    /// Grey, tilted strata with warm patches, lichen on what lies flat.
    Rgb granite(const GroundPoint& p) const;
    /// Red to pale level strata, dark varnish running down the faces.
    Rgb sandstone(const GroundPoint& p) const;
    /// Windblown, with ripples.
    Rgb sand(const GroundPoint& p) const;
    /// Stones and dust, the colour of the desert's flats.
    Rgb gravel(const GroundPoint& p) const;
    /// `dryness` 0 (lush) to 1 (straw).
    Rgb grass(const GroundPoint& p, double dryness) const;
    /// Needles, earth, moss.
    Rgb forest_floor(const GroundPoint& p) const;
    Rgb path(const GroundPoint& p) const;
    Rgb snow(const GroundPoint& p) const;
    /// `depth_m` of the water below the surface.
    Rgb water(const GroundPoint& p, double depth_m) const;
    Rgb ice(const GroundPoint& p) const;

    /// Patches about in [−1, 1]: some tens of metres, and some metres across.
    double patches(const Vec2& at_m) const { return patches_.fbm(at_m, {38.0, 3}); }
    double mottle(const Vec2& at_m) const { return mottle_.fbm(at_m, {5.0, 3, 0.6}); }

  private:
    Noise patches_;
    Noise mottle_;
    Noise strata_;
    Noise stone_;
};

/// Whether snow lies here: above a line, on slopes that hold it, in hollows first; the border is
/// ragged down to single voxels.
bool snow_lies(const GroundPoint& p, double line_m, double mottle);

}  // namespace probebake::worldgen
