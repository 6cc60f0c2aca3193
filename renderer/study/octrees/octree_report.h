// The report of `probebake study octrees`, from its results alone.
#pragma once

#include "study/octrees/octree_study.h"

namespace probebake::study {

/// The figures beside those of 1999, condensed: what the report's first table judges.
Json summarise_octrees(const HavranTables& tables, const Json& results, bool full);

void write_octree_report(const OctreeStudyParams& params, const HavranTables& tables,
                         OctreeStudyOutcome& outcome);

}  // namespace probebake::study
