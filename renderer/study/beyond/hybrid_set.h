// Every ray that the hybrid renderer could cast in some views, cast once: its image and counts for
// any price and for any order of refinement then follow without casting again.
//
// Costs are those of the renderer (hybrid_view.h): the start lists of tiles included, and the rays
// of a pixel from its tile's list or its own.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "render/hybrid.h"

namespace probebake::study {

/// A view, and the cubemap face whose pixels it is rendered for.
struct FaceView {
    View view;
    std::optional<CubeFace> face;

    bool renders(int x, int y) const;
};
/// The six faces of every position (voxels), n pixels per side.
std::vector<FaceView> cubemap_views(std::span<const Vec3> positions, int n);

/// Stages that are recorded: up to 8 × 8 cells, 69 rays; enough for costs that renderers of 21
/// rays can be compared at.
inline constexpr int kRecordedStages = 4;

struct RecordedPixel {
    struct Stage {
        Vec3 color{0.0};
        uint32_t rays = 0;  // up to this stage, as the two below
        uint32_t steps = 0;
        uint32_t box_tests = 0;
    };
    std::array<Stage, kRecordedStages> stages;
    PixelEvidence evidence;
    Vec3 truth{0.0};

    double squared_error(int stage) const;
};

/// How much it is worth to go on after a stage of a pixel; compared with the price.
using Score = std::function<double(const RecordedPixel&, int stage)>;
/// The renderer's own: predicted squared error per ray.
Score model_score(const ErrorModel& model = kErrorModel);
/// The geometric error of the nodes alone, as Müller 2020 refines.
Score node_error_score();
Score contrast_score();
/// What going on really brings per ray, looking ahead as far as it pays: no score can do better.
Score perfect_score();

struct HybridOutcome {
    double mse = 0.0;
    uint64_t pixels = 0;
    uint64_t rays = 0;
    uint64_t steps = 0;
    uint64_t box_tests = 0;

    double rmse() const;
};

class HybridSet {
  public:
    /// Truth: one image per view, of the pixels that it renders.
    HybridSet(const RenderScene& scene, std::span<const FaceView> views,
              std::span<const Image> truth, const HybridSwitches& switches);

    HybridOutcome outcome(const Score& score, double price) const;
    /// The outcome of the lowest price that takes at most so many steps; with no price that does,
    /// of one ray per pixel.
    HybridOutcome within_steps(const Score& score, uint64_t steps) const;
    /// The highest price whose error is at most so large; below 0, which refines all, where none
    /// is.
    double price_for_error(const Score& score, double rmse) const;
    std::span<const RecordedPixel> pixels() const { return pixels_; }

  private:
    std::vector<RecordedPixel> pixels_;
    uint64_t list_steps_ = 0;
};

/// The mean of 256 leaf rays per pixel at nested places of their own; black where the view's face
/// does not own the pixel.
Image nested_truth(const RenderScene& scene, const FaceView& view);

}  // namespace probebake::study
