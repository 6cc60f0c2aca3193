// NFF's objects as triangles.
//
// Spheres, cones and cylinders become inscribed facets that are nowhere farther from them than a
// tolerance; polygons and patches are cut into triangles. Colour is the material's times its Kd;
// lights, background, gloss and transmittance are left out.
#pragma once

#include <string>

#include "scene/mesh_parts.h"
#include "scene/nff/nff_file.h"

namespace probebake {

struct NffMeshParams {
    double tolerance = 0.01;  // > 0, in the file's units
    MeshLimits limits;
};

/// Throws IoError, naming `file`, where there are too many triangles.
TriangleMesh nff_mesh(const NffScene& scene, const NffMeshParams& params, const std::string& file);

}  // namespace probebake
