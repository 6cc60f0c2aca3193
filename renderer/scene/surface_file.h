// The triangles that a scene keeps of its mesh, on disk (io/checked_file.h has the format).
#pragma once

#include <filesystem>

#include "mesh/surface_triangles.h"

namespace probebake {

/// Throws IoError.
void save_surface(const std::filesystem::path& path, const SurfaceTriangles& surface);
/// Throws IoError for a file that is damaged, cut off or of something else.
SurfaceTriangles load_surface(const std::filesystem::path& path);

}  // namespace probebake
