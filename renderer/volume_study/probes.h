// Eight probes in and around a cloud over a generated mountain, with sun and sky, at a target.
#pragma once

#include "volume_study/clouds.h"

namespace probebake::volume_study {

/// Every probe is rendered twice with other random numbers: half of their mean squared difference
/// is the measured error. Writes the first one as OUT/probe.exr and as a panorama, OUT/probe.png.
study::TextTable probe_table(const Cloud& cloud, const std::filesystem::path& out,
                             const std::function<void(const std::string&)>& progress);

}  // namespace probebake::volume_study
