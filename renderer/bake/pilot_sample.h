// The pilot's pixels: drawn, measured against the truth, and rendered under any settings.
#pragma once

#include <vector>

#include "bake/irradiance_noise.h"
#include "bake/probe_view.h"
#include "bake/quality_search.h"
#include "io/cancel.h"

namespace probebake {

/// A setting that was rendered on the pilot's pixels.
struct CurvePoint {
    RenderSettings settings;
    uint64_t rays = 0;
    uint64_t steps = 0;
    double seconds = 0.0;  // of one thread
    MeasuredError error;
};

/// How many pixels the pilot of one state draws.
uint64_t pilot_pixels(const JobSpec& job);

/// All functions run on the calling arena, give the same values for any number of threads, and
/// throw Cancelled.
class PilotSample {
  public:
    /// Draws the pixels of up to 64 probes, half a per cent of the job within bounds; whole windows
    /// of SSIM where that is the target. Casts their truth and finds the exposure.
    PilotSample(const Scene& scene, const JobSpec& job, ReadyState state,
                const CancelToken& cancel);

    /// Casts what candidates of these renderers with leaf rays of this grid could cast. Grids in
    /// the order of kLeafGrids. Not for the hybrid renderer.
    void extend(const std::vector<RendererKind>& renderers, int leaf_grid);
    /// Casts what the hybrid renderer would at any price from this one up. Prices in falling order.
    void extend_hybrid(double price);

    /// The lowest price so far; infinite before.
    double recorded_price() const { return recorded_price_; }
    /// What the hybrid renderer makes of every pixel, from what is recorded.
    CurvePoint replayed(const RenderSettings& settings) const;

    /// Renders every pixel and measures the error.
    CurvePoint render(const RenderSettings& settings);
    /// Leaf rays with shifted grids, for jobs of irradiance alone: renders every pixel twice, with
    /// different shifts, and takes what the two differ by for their errors.
    CurvePoint render_leaf_rays(const RenderSettings& settings);

    const SearchSample& sample() const { return sample_; }
    /// Rays per side of r1 and of r2: the fewest of kTruthGrids whose noise leaves the error that
    /// the target allows in sight.
    int truth_grid() const { return truth_grid_; }
    /// Of truth and candidates.
    const CostStats& search_cost() const { return search_cost_; }

  private:
    struct Place {
        size_t probe = 0;
        CubePixel pixel;  // as stored; its owner is what is rendered
    };
    /// What a pixel is cast with.
    struct Target {
        size_t index;
        const RenderScene& scene;
        const View& view;
        const CubePixel& owner;
    };

    void choose_places();
    void add_square(size_t probe, RandomStream& random, int side);
    void cast_truth();
    void set_exposure();
    double truth_noise() const;
    Rgb other_leaf_rays(const Target& target, int leaf_grid, CostStats& stats) const;
    const IrradianceNorms& irradiance_norms(const std::vector<NoisyPixel>& sample);
    static void record_timed_stage(const HybridCast& cast, HybridRecord& record, CostStats& stats);
    double contrast_at(const Target& target, CostStats& stats) const;
    double variation_at(const Target& target, CostStats& stats) const;
    template <class Cast>
    CostStats for_each_pixel(Cast cast) const;

    const Scene& scene_;
    const JobSpec& job_;
    const ReadyState state_;
    const CancelToken& cancel_;
    std::vector<Place> places_;
    std::optional<IrradianceNorms> norms_;
    SearchSample sample_;
    int truth_grid_ = kTruthGrids.front();
    double recorded_price_ = std::numeric_limits<double>::infinity();
    CostStats search_cost_;
};

}  // namespace probebake
