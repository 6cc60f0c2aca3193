// A stand-in for "fluid", which was the author's own and is not public.
//
// Havran 1999 says of it: a fluid simulation around a ball, a mirror in the back that shows the
// whole scene again, 2,514 spheres and one polygon, many reflected rays. This one has the same
// numbers of objects and the same idea; none of its figures can be compared with the document's.
#pragma once

#include "scene/nff/nff_file.h"

namespace probebake::study {

/// 2,513 drops in a slab that gives way to a ball, before a mirror. Always the same.
NffScene fluid_stand_in();

}  // namespace probebake::study
