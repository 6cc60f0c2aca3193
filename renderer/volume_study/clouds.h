// The clouds of the volume study, placed in a box of 1 km, and rays through them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "math/random.h"
#include "volume/media.h"
#include "volume_study/volume_study.h"

namespace probebake::volume_study {

struct Cloud {
    std::string name;
    GridShape shape;
    double thickest = 0.0;  // ∫ density along the thickest of 64 × 64 vertical rays, m
};

std::vector<Cloud> load_clouds(const VolumeStudyParams& params);

/// A spec whose thickest column is `column` at density coefficients `absorb` and `scatter`, which
/// are relative: their largest sum is 1.
MediumSpec cloud_medium(const Cloud& cloud, double column, const Rgb& absorb, const Rgb& scatter,
                        double g);

/// A ray from outside towards a random point of the cloud's box.
Ray ray_at_cloud(const Cloud& cloud, RandomStream& random);

}  // namespace probebake::volume_study
