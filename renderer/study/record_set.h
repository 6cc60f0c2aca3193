// Recorded views that are judged together: the study view, or the cubemaps of some probes.
//
// Errors are against two images: the thesis's reference (4 × 4 leaf rays) and the truth (16 × 16).
// Exposure 1: albedo is a reflectance. Over several cubemaps the squared errors are averaged, SSIM
// too (docs/conventions.md, "Image metrics").
#pragma once

#include <functional>
#include <optional>

#include "image/cubemap.h"
#include "io/json.h"
#include "study/view_record.h"

namespace probebake::study {

/// How far images are from what they are compared with.
struct SetError {
    double rmse = 0.0;
    std::optional<double> ssim;             // none below 11 pixels
    std::optional<double> psnr_db() const;  // none where exact
};

struct Measured {
    Counts counts;
    SetError against_reference;
    SetError against_truth;
};

using Outcome = std::function<PixelOutcome(const PixelRecord&)>;

class RecordSet {
  public:
    /// One view; its truth may be known already.
    RecordSet(const RenderScene& scene, const View& view, std::optional<int> fixed_level = {},
              std::optional<Image> truth = {});
    /// Cubemaps of n pixels per face; positions in voxels.
    RecordSet(const RenderScene& scene, std::span<const Vec3> positions, int n);

    const std::vector<ViewRecord>& views() const { return views_; }
    Counts count(const Outcome& outcome) const;
    /// The image of view i.
    Image image(size_t i, const Outcome& outcome) const;
    Measured measure(const Outcome& outcome) const;
    const std::vector<Image>& truth() const { return truth_; }
    /// Largest variation of a pixel, misses left out.
    double largest_variation() const;

    /// The smallest threshold, to a part in 2^40, at which error-aware rendering takes at most so
    /// many steps.
    double threshold_for_steps(uint64_t steps, double decay) const;
    /// The smallest normaliser likewise; infinity where no refinement is affordable.
    double normaliser_for_steps(uint64_t steps, MissesInKernel misses) const;

  private:
    SetError compare(const std::vector<Image>& images, const std::vector<Image>& to) const;
    std::vector<Image> images(const Outcome& outcome) const;

    bool cubemaps_ = false;
    std::vector<ViewRecord> views_;
    std::vector<Image> truth_;
    std::vector<Image> reference_;
};

/// {"pixels", "rays", "hit_rays", "discarded_rays", "steps", "classes", "reference": {"rmse",
/// "psnr_db", "ssim"}, "truth": {...}}.
Json write_counts(const Counts& counts);
Json write_measured(const Measured& measured);

}  // namespace probebake::study
