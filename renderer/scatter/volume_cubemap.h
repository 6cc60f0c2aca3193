// A cubemap of a scene with media: samples per pixel where the variance is, until target or budget.
//
// Every pixel begins with `first_samples` paths. With σ² the variance of a path's radiance (mean
// over R, G, B) and n the paths of a pixel, the mean squared error is predicted as the mean of
// σ²/n; rounds go on with n ∝ σ, the least cost for that sum, until it is target². σ is judged by
// the eight neighbours, never by the pixel itself: a number of samples that its own samples decided
// on would bias it. Points of a pixel are a scrambled Sobol sequence over the footprint and the
// first flight; σ²/n takes them for independent, which overstates the error.
//
// Every pixel is a pure function of scene, settings and key; the same bytes for any number of
// threads. Shared pixels are rendered once and copied.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "image/cubemap.h"
#include "io/cancel.h"
#include "scatter/path_tracer.h"

namespace probebake {

struct VolumeQuality {
    double target_rmse = 0.0;  // radiance; 0: first_samples in every pixel
    int first_samples = 16;    // ≥ 2
    int most_samples = 4096;   // of a pixel
    /// Paths that may be traced in all, first_samples in every pixel in any case; none: no budget.
    std::optional<uint64_t> most_paths;
    /// The same of seconds, all threads together: looked at between rounds.
    std::optional<double> most_seconds;
};

struct VolumePixel {
    Rgb standard_error{0.0f};
    double distance_m = 0.0;  // mean; a path into the sky counts as range.end
    double squared_distance_m2 = 0.0;
    int samples = 0;
};

struct VolumeCubemap {
    Cubemap color;
    std::vector<VolumePixel> pixels;           // in the order of the cubemap's image
    std::array<PathCount, kFaceCount> faces;   // of the pixels that they own
    std::array<double, kFaceCount> seconds{};  // summed over threads
    double predicted_rmse = 0.0;
    bool target_met = false;
    bool limited = false;  // most_paths or most_seconds stood in the way
    int rounds = 1;

    PathCount count() const;
};

struct VolumeView {
    Vec3 origin_m{0.0};
    int face_size_px = 64;
    TRange range;      // of first rays, m; its end finite, or the distances are infinite
    uint64_t key = 1;  // of all random numbers
};

/// Names a path of a pixel: all indices of a key together are a low-discrepancy set over footprint
/// and first flight; sets of different keys are independent.
struct PixelPath {
    uint64_t key = 0;
    uint32_t index = 0;
};
PathResult pixel_path(const PathTracer& tracer, const VolumeView& view, const CubePixel& pixel,
                      const PixelPath& name, PathCount& count);

/// Throws Cancelled; std::invalid_argument for settings out of range.
VolumeCubemap render_volume_cubemap(const PathTracer& tracer, const VolumeView& view,
                                    const VolumeQuality& quality, const CancelToken& cancel);

}  // namespace probebake
