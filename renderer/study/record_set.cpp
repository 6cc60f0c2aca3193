#include "study/record_set.h"

#include <cmath>
#include <limits>

#include "image/metrics.h"

namespace probebake::study {
namespace {

Cubemap assemble(std::span<const Image> faces) {
    const int n = faces[0].width();
    Cubemap cubemap(n);
    for (const CubeFace face : kCubeFaces) {
        const Image& image = faces[static_cast<size_t>(index_of(face))];
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) cubemap.at({face, x, y}) = image.at(x, y);
        }
    }
    cubemap.share_edges();
    return cubemap;
}

/// The smallest x in [low, high] with cost(x) ≤ most, cost falling in x, by halving; high where
/// even that costs more.
template <class Cost>
double smallest_affordable(double low, double high, uint64_t most, Cost cost) {
    if (cost(low) <= most) return low;
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (low + high);
        (cost(middle) <= most ? high : low) = middle;
    }
    return high;
}

Json write_error(const SetError& error) {
    const auto psnr = error.psnr_db();
    return {{"rmse", error.rmse},
            {"psnr_db", psnr ? Json(*psnr) : Json(nullptr)},
            {"ssim", error.ssim ? Json(*error.ssim) : Json(nullptr)}};
}

}  // namespace

std::optional<double> SetError::psnr_db() const {
    if (rmse == 0.0) return std::nullopt;
    return -20.0 * std::log10(rmse);
}

RecordSet::RecordSet(const RenderScene& scene, const View& view, std::optional<int> fixed_level,
                     std::optional<Image> truth) {
    views_.push_back(record_view(scene, view, {.fixed_level = fixed_level}));
    truth_.push_back(truth ? std::move(*truth) : render_truth(scene, view));
    reference_ = images(reference_outcome);
}

RecordSet::RecordSet(const RenderScene& scene, std::span<const Vec3> positions, int n)
    : cubemaps_(true) {
    for (const Vec3& position : positions) {
        for (const CubeFace face : kCubeFaces) {
            const View view = cube_face_view(face, n, position);
            views_.push_back(record_view(scene, view, {.face = face}));
            truth_.push_back(render_truth(scene, view, face));
        }
    }
    reference_ = images(reference_outcome);
}

Counts RecordSet::count(const Outcome& outcome) const {
    Counts counts;
    for (const ViewRecord& view : views_) {
        for (const PixelRecord& pixel : view.pixels) {
            if (pixel.rendered) counts.add(outcome(pixel));
        }
    }
    return counts;
}

Image RecordSet::image(size_t i, const Outcome& outcome) const {
    const ViewRecord& record = views_[i];
    Image image(record.view.width_px, record.view.height_px);
    for (size_t p = 0; p < record.pixels.size(); ++p) {
        if (record.pixels[p].rendered) image.pixels()[p] = Rgb(outcome(record.pixels[p]).color);
    }
    return image;
}

std::vector<Image> RecordSet::images(const Outcome& outcome) const {
    std::vector<Image> made;
    for (size_t i = 0; i < views_.size(); ++i) made.push_back(image(i, outcome));
    return made;
}

SetError RecordSet::compare(const std::vector<Image>& images, const std::vector<Image>& to) const {
    std::vector<ImageError> errors;
    if (cubemaps_) {
        for (size_t i = 0; i < images.size(); i += kFaceCount) {
            errors.push_back(compare_cubemaps(assemble(std::span(images).subspan(i, kFaceCount)),
                                              assemble(std::span(to).subspan(i, kFaceCount)), 1.0)
                                 .cube);
        }
    } else {
        for (size_t i = 0; i < images.size(); ++i) {
            errors.push_back(compare_images(images[i], to[i], 1.0));
        }
    }
    double squared = 0.0;
    double ssim = 0.0;
    for (const ImageError& error : errors) {
        squared += error.rmse * error.rmse;
        ssim += error.ssim.value_or(std::numeric_limits<double>::quiet_NaN());
    }
    const auto count = static_cast<double>(errors.size());
    SetError mean{.rmse = std::sqrt(squared / count)};
    if (!std::isnan(ssim)) mean.ssim = ssim / count;
    return mean;
}

Measured RecordSet::measure(const Outcome& outcome) const {
    const std::vector<Image> made = images(outcome);
    return {count(outcome), compare(made, reference_), compare(made, truth_)};
}

double RecordSet::largest_variation() const {
    double largest = 0.0;
    for (const ViewRecord& view : views_) {
        for (const PixelRecord& pixel : view.pixels) largest = std::max(largest, pixel.variation);
    }
    return largest;
}

double RecordSet::threshold_for_steps(uint64_t steps, double decay) const {
    // E_N lies in [−0.1 (1 + d), 1 + d], with some room for the fit's overshoot.
    return smallest_affordable(-0.2 * (1.0 + decay), 1.2 * (1.0 + decay), steps,
                               [&](double threshold) {
                                   return count([&](const PixelRecord& pixel) {
                                              return error_aware_outcome(pixel, threshold, decay);
                                          })
                                       .steps;
                               });
}

double RecordSet::normaliser_for_steps(uint64_t steps, MissesInKernel misses) const {
    const auto cost = [&](double normaliser) {
        return count([&](const PixelRecord& pixel) {
                   return adaptive_outcome(pixel, normaliser, misses);
               })
            .steps;
    };
    constexpr double kFinest = -60.0;  // log2: beyond any difference of luminances in float
    constexpr double kCoarsest = 30.0;
    const double exponent = smallest_affordable(kFinest, kCoarsest, steps,
                                                [&](double e) { return cost(std::exp2(e)); });
    const double normaliser = std::exp2(exponent);
    return cost(normaliser) <= steps ? normaliser : std::numeric_limits<double>::infinity();
}

Json write_counts(const Counts& counts) {
    return {{"pixels", counts.pixels},
            {"rays", counts.rays},
            {"hit_rays", counts.hit_rays},
            {"discarded_rays", counts.discarded_rays},
            {"rays_per_hit_pixel", counts.rays_per_hit_pixel()},
            {"steps", counts.steps},
            {"classes", counts.classes}};
}

Json write_measured(const Measured& measured) {
    Json json = write_counts(measured.counts);
    json["reference"] = write_error(measured.against_reference);
    json["truth"] = write_error(measured.against_truth);
    return json;
}

}  // namespace probebake::study
