// Random numbers as the generators need them.
//
// Azimuths are drawn by rejection, without trigonometry: the same bits on every machine. Draw once
// per statement: the order of evaluation within an expression is the compiler's.
#pragma once

#include "math/random.h"
#include "math/vec.h"

namespace probebake::worldgen {

/// Uniform on the unit circle of the ground plane.
Vec3 random_azimuth(RandomStream& random);
/// Uniform in [from, to).
double between(RandomStream& random, double from, double to);
/// Along the ground in a random direction, between `from` and `to` far.
Vec3 random_offset(RandomStream& random, double from, double to);

}  // namespace probebake::worldgen
