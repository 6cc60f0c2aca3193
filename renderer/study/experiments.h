// The experiments, one function and one file each (experiment.h).
#pragma once

#include "study/experiment.h"

namespace probebake::study {

/// Tables 4.1, 5.2-5.17: every renderer on the study view, with pictures of where the rays went.
Json run_rendering(const ExperimentInput& input);
/// Table 5.1 and the choice of the decay (5.1.4).
Json run_threshold_decay(const ExperimentInput& input);
/// Tables 5.27 and 5.28.
Json run_thresholds(const ExperimentInput& input);
/// Error-aware against adaptive at equal steps, from 1.5 to 12 times one ray per pixel.
Json run_equal_steps(const ExperimentInput& input);
/// Tables 5.29 and 5.30, with fixed levels of detail and with those of the pixels.
Json run_resolutions(const ExperimentInput& input);
/// Light probes: cubemaps, all renderers, and equal steps.
Json run_probes(const ExperimentInput& input);
/// The slackline (3.7, 3.8) and the torch (1.1): how much of something thin is left.
Json run_thin(const ExperimentInput& input);

/// Tables 5.18-5.26: four positions of the sun.
Json run_times_of_day(const ExperimentInput& input);
Json times_of_day_params();
/// Figures 3.4-3.6: the Cornell box's beam by shadow rays.
Json run_beam(const ExperimentInput& input);
/// Shadow rays by level of detail: steps and wrong answers.
Json run_shadow_rays(const ExperimentInput& input);
/// Nodes that stand on both sides of a wall.
Json run_walls(const ExperimentInput& input);

/// Rows {"renderer", counts, errors} of every renderer on a set of views, error-aware with the
/// thesis's threshold and decay, adaptive with its steps and with the global normalisers.
Json measure_renderers(const RecordSet& set, const GlobalNormalisers& normalisers);
/// Rows {"times_base", "error_aware", "adaptive", "adaptive_black"} of kBudgets.
Json measure_equal_steps(const RecordSet& set);

}  // namespace probebake::study
