// Every ray that the thesis's renderers could cast in a view, cast once: their images and counts
// for any threshold, decay and normaliser then follow without casting again.
//
// Müller 2020, 5.1: reference (4 × 4 leaf rays), level of detail (the first ray alone), adaptive
// and error-aware. Counts: a ray "hits" where it met a voxel or node; the thesis leaves the others
// out of its tables. First and discarded rays are always counted.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "render/adaptive.h"
#include "render/view.h"

namespace probebake::study {

/// Rays of one kind in a pixel.
struct RayGroup {
    Rgb color{0.0f};  // mean
    uint32_t steps = 0;
    uint16_t rays = 0;
    uint16_t hits = 0;
};

struct PixelRecord {
    /// A ray at a level of detail; E_N = own_error + decay · child_error.
    struct Coarse {
        RayGroup ray;
        double own_error = 0.0;
        double child_error = 0.0;
        double error(double decay) const { return own_error + decay * child_error; }
    };
    struct Quadrant {
        Coarse coarse;
        RayGroup leaves;  // 2 × 2
    };
    bool rendered = false;  // false: the pixel belongs to another face of the cubemap
    Coarse first;
    std::array<Quadrant, 4> quadrants;
    RayGroup two_by_two;           // leaf rays of the adaptive renderer
    double variation = 0.0;        // of the one-ray image, misses left out (kernel A)
    double variation_black = 0.0;  // misses as black (kernel A')
};

struct ViewRecord {
    View view;
    std::vector<PixelRecord> pixels;  // row by row
};

struct RecordParams {
    /// Only the pixels that this face of a cubemap owns.
    std::optional<CubeFace> face;
    /// Level of detail of the first ray where it is not the pixel's (5.5: fixed levels).
    std::optional<int> fixed_level;
};
ViewRecord record_view(const RenderScene& scene, const View& view, const RecordParams& params = {});

/// The mean of 16 × 16 leaf rays per pixel; black where the face does not own the pixel.
Image render_truth(const RenderScene& scene, const View& view,
                   const std::optional<CubeFace>& face = {});

/// What a renderer makes of a pixel.
struct PixelOutcome {
    Vec3 color{0.0};
    uint32_t kept_rays = 0;
    uint32_t kept_hits = 0;
    uint32_t discarded_rays = 0;
    uint32_t discarded_hits = 0;
    uint64_t steps = 0;
    /// 0: not refined, 1: refined once (2 × 2), 2: some of it refined to 4 × 4.
    int refinement = 0;
};
PixelOutcome reference_outcome(const PixelRecord& pixel);
PixelOutcome lod_outcome(const PixelRecord& pixel);
PixelOutcome adaptive_outcome(const PixelRecord& pixel, double normaliser, MissesInKernel misses);
PixelOutcome error_aware_outcome(const PixelRecord& pixel, double threshold, double decay);

struct Counts {
    uint64_t pixels = 0;
    uint64_t rays = 0;      // kept and discarded
    uint64_t hit_rays = 0;  // of these, those that hit: what the thesis counts
    uint64_t discarded_rays = 0;
    uint64_t steps = 0;
    /// Pixels none of whose kept rays hit; then the others by PixelOutcome::refinement.
    std::array<uint64_t, 4> classes{};

    void add(const PixelOutcome& outcome);
    /// Rays per pixel that hits anything, as the thesis counts both.
    double rays_per_hit_pixel() const;
};

}  // namespace probebake::study
