// The exact error table, from areas of projections: the oracle of the others.
//
// A line along d is known by its moment m = p × d (p any point of it; m · d = 0). It meets a cube
// of half side h centred at c exactly where |m − c × d|_a ≤ h·(|d_b| + |d_c|) for the three axes:
// in the plane of moments the projection of a cube is an intersection of three slabs, a hexagon
// (a parallelogram or a square where components of d vanish), and those of the eight children are
// translates of one. The slabs of all children have the same width, so a set of children has in
// common the intersection of three slabs again: a rectangle clipped by a strip. Inclusion and
// exclusion over these areas gives the area of the union for all 256 masks at once.
//
// Only +, −, ×, ÷: exact to about 1e-14 for every direction, axis-parallel ones included.
#pragma once

#include "error/error_table.h"

namespace probebake {

/// Area of the projection along the unit direction d of each mask's children, for a parent of
/// side 1; the whole parent's is |dx| + |dy| + |dz|.
MaskErrors projected_areas(const Vec3& d);

/// e = 1 − projected area of the children / projected area of the parent. Throws
/// std::invalid_argument unless every direction is of unit length.
MaskErrors projected_area_errors(const Vec3& direction);
ErrorTable projected_area_errors(std::vector<Vec3> directions);

}  // namespace probebake
