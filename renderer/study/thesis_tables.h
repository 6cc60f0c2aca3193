// Figures of A. Müller, "Error-Based Adaptive Voxel Raytracing", TUM 2020, to stand beside ours.
//
// Only the ones that the report compares; the numbers of the tables are beside them. The thesis
// counts rays that hit, the first and the discarded ones included (but see its inconsistencies,
// thesis_check.h). Desert, forest, mountain and biomes are areas of a production data set that is
// not public: ratios can be compared, absolute counts cannot.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace probebake::study {

/// A renderer on an area, albedo, 512² pixels.
struct ThesisRenderer {
    uint64_t rays;
    uint64_t steps;
    /// Pixels without any hit; 1, 4 and 16 rays (adaptive) or level of detail 2, 1, 0.
    std::array<uint64_t, 4> classes;
    double psnr_db;
    double rmse;
    double ssim;
};

/// The same, lit at a time of day.
struct ThesisTimeOfDay {
    uint64_t adaptive_rays;
    uint64_t error_aware_rays;
    uint64_t adaptive_steps;
    uint64_t error_aware_steps;
    double adaptive_rmse;
    double error_aware_rmse;
};

struct ThesisArea {
    const char* name;
    uint64_t voxels;  // table 4.1
    uint64_t octree_nodes;
    ThesisRenderer adaptive;               // 5.2, 5.3, 5.5 and so on
    ThesisRenderer error_aware;            // 5.2, 5.4, 5.5 and so on
    std::array<ThesisTimeOfDay, 4> times;  // 5.18, 5.20 and so on
};
std::span<const ThesisArea> thesis_areas();

/// Table 5.1, desert: rays by decay (rows) and threshold (columns).
inline constexpr std::array<double, 6> kThesisDecays = {0.05, 0.1, 0.15, 0.2, 0.25, 0.3};
inline constexpr std::array<double, 6> kThesisThresholds = {0.175, 0.15, 0.125, 0.1, 0.075, 0.05};
const std::array<std::array<uint64_t, 6>, 6>& thesis_decay_rays();

/// Tables 5.27 and 5.28, desert, error-aware, by kThesisThresholds.
struct ThesisThreshold {
    uint64_t rays;
    uint64_t steps;
    double psnr_db;
    double rmse;
    double ssim;
};
const std::array<ThesisThreshold, 6>& thesis_thresholds();

/// Tables 5.29 and 5.30, desert.
struct ThesisResolution {
    int view_px;
    uint64_t adaptive_rays;
    uint64_t error_aware_rays;
    uint64_t adaptive_steps;
    uint64_t error_aware_steps;
    double adaptive_rmse;
    double error_aware_rmse;
};
const std::array<ThesisResolution, 4>& thesis_resolutions();

}  // namespace probebake::study
