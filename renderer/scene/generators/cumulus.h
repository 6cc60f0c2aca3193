// A cumulus cloud, generated: the same bits on every machine.
//
// A heap of spheres (towers on a flat base, each smaller one on the surface of a larger one) whose
// distance field is displaced by octaves of gradient noise; the density rises from 0 to 1 over
// `edge` of the cloud's width and varies by a third inside. Values are rounded to half precision,
// which DensityGrid keeps losslessly.
#pragma once

#include "volume/density_grid.h"

namespace probebake {

struct CumulusParams {
    int size = 1024;  // lattice points per side, 16 to 4096
    uint64_t seed = 1;
    int spheres = 40;
    double edge = 0.02;           // of the size
    double displacement = 0.055;  // of the size, at most
};

/// In index space [0, size)³, y up. Parallel on the calling arena. Throws std::invalid_argument.
DensityGrid make_cumulus(const CumulusParams& params);

}  // namespace probebake
