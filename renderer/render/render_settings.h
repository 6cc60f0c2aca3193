// The renderers and what steers them.
#pragma once

#include <limits>
#include <optional>

#include "error/node_error.h"

namespace probebake {

enum class RendererKind {
    kReference,   // leaf_grid × leaf_grid leaf rays in every pixel (Müller 2020, 5.1.1)
    kLod,         // one ray per pixel, at the level of detail of the pixel
    kAdaptive,    // refines where the luminance of the one-ray image varies (5.1.2)
    kErrorAware,  // refines where the visibility error of the node hit is large (5.1.3)
    kHybrid,      // leaf visibility, LOD colours; refines where predicted error pays (hybrid.h)
    kPaths,       // volumetric paths through media (scatter/), which the bake casts itself
};

/// What the adaptive renderer's 3×3 kernel does with pixels whose ray missed.
enum class MissesInKernel {
    kLeftOut,  // the thesis's choice
    kBlack,
};

/// Parts of the hybrid renderer, on but for the study that shows what each of them brings.
struct HybridSwitches {
    /// Rays start at the nodes that the beam of their tile or pixel can meet (start_list.h).
    bool start_lists = true;
    /// Stages add rays to those that there are, at nested places; off: regular grids, each in
    /// place of the one before.
    bool nested_rays = true;

    bool operator==(const HybridSwitches&) const = default;
};

struct RenderSettings {
    RendererKind kind = RendererKind::kErrorAware;
    /// Error above which a ray is discarded and refined. Below 0 every ray is, misses too.
    double threshold = kThesisThreshold;
    /// Weight of the children's mean error in a node's error (5.1.4).
    double decay = kThesisDecay;
    /// Most leaf rays per pixel side. The reference renderer casts so many everywhere; the
    /// error-aware one casts 4 × 4, as the thesis's, and goes on to 8 and 16 where `spread` says
    /// so.
    int leaf_grid = 4;
    /// The reference renderer's grid lies elsewhere in every pixel (grid_shift): of one ray per
    /// pixel, more in the mean over many.
    bool shifted_grid = false;
    /// A refined pixel goes on where the standard error of its rays' mean (root mean square over
    /// R, G, B, in units of radiance) exceeds this.
    double spread = std::numeric_limits<double>::infinity();
    /// The hybrid renderer's: a pixel is refined while the squared error (radiance², mean over R,
    /// G, B) that is predicted of it, per ray of the next stage, exceeds this.
    double price = 0.0;
    /// Cells per side of the stage up to which every pixel is refined, whatever is predicted of it.
    int least_grid = 1;
    HybridSwitches hybrid;
    /// Of paths: in every pixel to begin with; and the root mean square standard error (radiance)
    /// down to which more are added where the variance is, 0: none are added.
    int samples = 16;
    double noise = 0.0;
    /// Level of detail of the first ray: the pixel's footprint, or a fixed octree level (each
    /// refinement goes one level down).
    std::optional<int> fixed_level;
    /// Sum of squared luminance differences that counts as 1 in the adaptive renderer.
    double normaliser = 1.0;
    MissesInKernel misses_in_kernel = MissesInKernel::kLeftOut;

    bool operator==(const RenderSettings&) const = default;
};

const char* name_of(RendererKind kind);

}  // namespace probebake
