// Rays to emissive voxels against finding them by scattering alone: variance and cost.
#pragma once

#include <functional>
#include <string>

#include "study/text_table.h"

namespace probebake::volume_study {

/// Worlds with few, many, a million and no emissive voxels, in thin and in thick fog; `paths` per
/// row. Of the counted figures the table is exact and repeatable.
study::TextTable emitter_table(int paths, const std::function<void(const std::string&)>& progress);

}  // namespace probebake::volume_study
