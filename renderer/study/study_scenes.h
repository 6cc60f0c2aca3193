// The scenes that the thesis's experiments are repeated on, and the view it looks at them from.
//
// Landscapes and structures are generated at the size asked for; worldA and the LiDAR terrain are
// read from a folder of real data (2048 voxels a side whatever the size) and left out without one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/pixel.h"
#include "scene/scene_library.h"

namespace probebake::study {

enum class SceneKind {
    kTerrain,    // stands for an area of the thesis
    kWorld,      // real data
    kStructure,  // thin structures over flat ground
    kQuestion,   // made for one experiment only
};

struct StudyScene {
    std::string name;
    SceneKind kind = SceneKind::kTerrain;
    SceneFile file;
    /// Where in its data folder it should be; no value where it is generated or present.
    std::optional<std::string> missing;
};

/// All scenes, terrains first. `size` is the side of the generated ones, in voxels.
std::vector<StudyScene> study_scenes(int size,
                                     const std::optional<std::filesystem::path>& data_folder);

/// The thesis's view (5.1.1): straight down on the map's middle, 90 degrees, size / 4 pixels a
/// side, from size / 2 voxels above the mean ground, so that a pixel covers 4 × 4 voxels there; off
/// the voxel grid. `view_px` changes the number of pixels alone.
View study_view(const Scene& scene, int size, std::optional<int> view_px = {});

/// A view straight down on a point (voxels) from a height above it at which a pixel's footprint is
/// `footprint` voxels.
View view_down_on(const Vec3& target, double footprint, int view_px);

/// Albedo of a scene, black where nothing is hit.
RenderScene albedo_of(const Scene& scene);

}  // namespace probebake::study
