// Whole images and cubemaps by any of the renderers, in tiles, in parallel, cancellable.
//
// Every pixel is a pure function of the scene, the view and the settings, and statistics are added
// up in tile order: the same bytes and counts for any number of threads. Work runs on the calling
// oneTBB arena.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "image/cubemap.h"
#include "io/cancel.h"
#include "render/pixel.h"

namespace probebake {

/// What the aux file holds besides the colour.
struct PixelAux {
    float distance = 0.0f;          // mean radial distance, voxels; a miss counts as range.t_max
    float squared_distance = 0.0f;  // its mean square, voxels²
    Rgb standard_error{0.0f};       // PixelSums::standard_error
    float samples = 0.0f;           // kept rays
    float predicted_error = 0.0f;   // squared error that the hybrid renderer expects to be left
};

struct ViewRender {
    Image color;
    std::vector<PixelAux> aux;  // row by row
    CostStats stats;
    uint64_t pixels = 0;   // rendered: those that the face owns
    bool limited = false;  // the ray limit left something undone that the settings ask for

    void store(int x, int y, const PixelSums& sums);
};

/// What of a view is rendered, and for how much at most.
struct ViewExtent {
    /// Only the pixels that this cubemap face owns.
    std::optional<CubeFace> face;
    /// Most rays to cast, kept and discarded, at least one per pixel. The renderer then spends
    /// them where its own criterion is largest: error-aware by the node errors of the first rays,
    /// adaptive by a larger normaliser, reference by fewer rays in every pixel.
    std::optional<uint64_t> ray_limit;
};

ViewRender render_view(const RenderScene& scene, const View& view, const RenderSettings& settings,
                       const CancelToken& cancel, const ViewExtent& extent = {});

struct CubemapRender {
    Cubemap color;
    std::vector<PixelAux> aux;  // in the order of the cubemap's image
    std::array<CostStats, kFaceCount> faces;
    std::array<uint64_t, kFaceCount> pixels{};
    bool limited = false;  // as in ViewRender

    CostStats total() const;
};

/// The cubemap of n pixels per face seen from `origin` (voxels); shared pixels are rendered once,
/// by the lowest face that holds them, and copied. A ray limit is shared among the faces by their
/// pixels. Throws Cancelled.
CubemapRender render_cubemap(const RenderScene& scene, const Vec3& origin, int n,
                             const RenderSettings& settings, const CancelToken& cancel,
                             std::optional<uint64_t> ray_limit = {});

}  // namespace probebake
