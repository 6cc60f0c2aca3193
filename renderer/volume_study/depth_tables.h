// Tables 1 and 2 of the supplemental: what octree depth does to delta and decomposition tracking.
#pragma once

#include "volume_study/clouds.h"

namespace probebake::volume_study {

/// One table per cloud and thickness.
std::vector<study::TextTable> depth_tables(const std::vector<Cloud>& clouds,
                                           const VolumeStudyParams& params,
                                           const std::function<void(const std::string&)>& progress);

}  // namespace probebake::volume_study
