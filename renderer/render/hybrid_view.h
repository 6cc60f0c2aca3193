// A view by the hybrid renderer (hybrid.h).
//
// Without a ray limit every pixel goes its own way after the first rays. With one, pixels go on in
// rounds, a quarter of those that wait at a time, the largest predicted gains first, as long as the
// rays last: a priority queue in parallel steps, the same for any number of threads.
// HybridCubemap keeps its pixels between refinements, so that a cubemap that turns out to be too
// coarse is refined further instead of rendered again: refine_to(p1), then refine_to(p2) with
// p2 < p1 ends with the bytes and the counts of p2 alone. It takes some 260 bytes a pixel.
#pragma once

#include <memory>

#include "render/render.h"

namespace probebake {

ViewRender render_hybrid_view(const RenderScene& scene, const View& view,
                              const RenderSettings& settings, const CancelToken& cancel,
                              const ViewExtent& extent);

class HybridView;

class HybridCubemap {
  public:
    /// Casts the first rays. `scene` and `cancel` outlive it. Throws Cancelled.
    HybridCubemap(const RenderScene& scene, const Vec3& origin, int n, const CancelToken& cancel);
    ~HybridCubemap();

    /// Mean squared differences of colour within pixels that other rays have shown, in the order of
    /// the cubemap's image (PixelEvidence::hidden).
    void reveal(const std::vector<double>& differences);
    /// Prices of 0 and more, in falling order; least grids (RenderSettings) in rising order. Throws
    /// Cancelled.
    void refine_to(double price, int least_grid = 1);
    /// No price from this one up has any pixel go on.
    double largest_gain() const;
    /// Sum of the pixels' predicted squared errors (radiance²), each times its weight: in the order
    /// of the cubemap's image, 0 for those that their face does not own.
    double predicted_sum(const std::vector<double>& weights) const;
    CubemapRender render() const;

  private:
    int n_;
    std::array<std::unique_ptr<HybridView>, kFaceCount> views_;
};

}  // namespace probebake
