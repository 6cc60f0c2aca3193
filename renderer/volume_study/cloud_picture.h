// Small pictures of a cloud from its side, the same rays for whatever renders them, and what they
// are off by.
//
// Parallel rays along −z, `side` × `side` pixels over the cloud's box. Every path is keyed by
// (key, pixel, sample); pixels are rendered in parallel, counts and processor time summed in order.
#pragma once

#include "image/image.h"
#include "track/track.h"
#include "volume_study/clouds.h"

namespace probebake::volume_study {

struct PictureParams {
    int side = 32;
    int samples = 16;
    uint64_t key = 1;
    /// |pixel| beyond this is brought back to it: half floats end there (supplemental 2.3).
    double clamp = 65504.0;
};

struct PictureCost {
    uint64_t counted = 0;  // look-ups and leaf steps
    uint64_t faults = 0;
    double seconds = 0.0;         // of processors
    double largest_weight = 0.0;  // throughput of any channel of any path

    PictureCost& operator+=(const PictureCost& o);
};

struct CloudPicture {
    std::vector<Vec3> pixels;
    PictureCost cost;
};

/// One path: its radiance; what it cost is added.
using PathFunction = std::function<Vec3(const Ray& ray, uint64_t key, PictureCost& cost)>;

CloudPicture render_picture(const Cloud& cloud, const PictureParams& params,
                            const PathFunction& path);

/// Mean over pixels and channels of (a − r1)(a − r2): the squared error of a against the truth that
/// r1 and r2 are independent estimates of, without their noise. Slightly negative where there is
/// little to find.
double squared_error(const CloudPicture& a, const CloudPicture& r1, const CloudPicture& r2);

/// Pictures side by side, rows below each other, every pixel `zoom` wide.
Image mosaic(const std::vector<std::vector<const CloudPicture*>>& rows, int side, int zoom);

}  // namespace probebake::volume_study
