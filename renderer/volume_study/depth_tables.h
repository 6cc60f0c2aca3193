// Tables 1 and 2 of the supplemental: what octree depth does to delta and decomposition tracking.
#pragma once

#include "volume_study/clouds.h"

namespace probebake::volume_study {

/// Two tables per cloud and thickness: counts, and CPU times as in tables 1 and 2. Walks and
/// look-ups are timed by themselves along the flights' lines and scaled to their counts; the
/// tracker has the rest.
std::vector<study::TextTable> depth_tables(const std::vector<Cloud>& clouds,
                                           const VolumeStudyParams& params,
                                           const std::function<void(const std::string&)>& progress);

}  // namespace probebake::volume_study
