// Trackers compared: variance × cost in path tracing, the control swept, figure 4's first flights.
#pragma once

#include "volume_study/clouds.h"

namespace probebake::volume_study {

/// Every tracker on gray, 1:2:4, figure 4's absorbing medium, coloured albedo 1 and 1:10:100: one
/// table per medium. Efficiencies are 1 / (variance × cost) against per-channel delta flights.
std::vector<study::TextTable> efficiency_tables(
    const Cloud& cloud, int samples, const std::function<void(const std::string&)>& progress);

/// Figures 1 to 3: weighted decomposition with the control from 0 to the majorant.
/// Also as a plot in `out`.
study::TextTable control_table(const Cloud& cloud, int samples, const std::filesystem::path& out);

/// Figure 4: cost, largest throughput and variance to the first real collision or the exit.
study::TextTable first_flight_table(const Cloud& cloud, int samples);

}  // namespace probebake::volume_study
