#include "scene/vdb/vdb_file.h"
#include "volume_study/stability.h"

namespace probebake::volume_study {

std::vector<StabilityCase> vdb_cases() {
    return {at_most("NaN anywhere in the input", ".vdb files: this build reads none",
                    reads_vdb() ? 1.0 : 0.0, 0)};
}

}  // namespace probebake::volume_study
