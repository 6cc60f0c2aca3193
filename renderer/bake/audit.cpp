#include "bake/audit.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bake/probe_view.h"
#include "image/ssim.h"

namespace probebake {
namespace {

constexpr double kUniformShare = 0.5;

/// Largest squared difference of luminance to the four neighbours on the face.
double contrast(const Cubemap& cube, const CubePixel& p) {
    const int n = cube.face_size();
    const double here = luminance(cube.at(p));
    double largest = 0.0;
    const auto compare = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= n || y >= n) return;
        largest = std::max(largest, std::abs(luminance(cube.at({p.face, x, y})) - here));
    };
    compare(p.x - 1, p.y);
    compare(p.x + 1, p.y);
    compare(p.x, p.y - 1);
    compare(p.x, p.y + 1);
    return largest * largest;
}

/// Predicted squared error of a stored pixel.
double predicted(const AuditSpec& spec, size_t i, const CubePixel& pixel) {
    const PixelAux& aux = spec.aux[i];
    return aux.predicted_error > 0.0f ? aux.predicted_error
                                      : contrast(spec.as_written, pixel) / aux.samples;
}

/// Probability of every stored pixel to be drawn.
std::vector<double> draw_probabilities(const AuditSpec& spec) {
    const int n = spec.as_written.face_size();
    const Weighting weighting = spec.drawn_for_sh ? Weighting::kSolidAngle : spec.weighting;
    std::vector<double> probability(spec.aux.size());
    double sum = 0.0;
    for (size_t i = 0; i < probability.size(); ++i) {
        const CubePixel pixel = pixel_at(i, n);
        const double error = predicted(spec, i, pixel);
        probability[i] =
            pixel_weight(weighting, pixel, n) * (spec.drawn_for_sh ? std::sqrt(error) : error);
        sum += probability[i];
    }
    const double uniform = 1.0 / static_cast<double>(probability.size());
    for (double& p : probability) {
        p = sum > 0.0 ? kUniformShare * uniform + (1.0 - kUniformShare) * p / sum : uniform;
    }
    return probability;
}

class AuditRun {
  public:
    AuditRun(const AuditSpec& spec, const CancelToken& cancel)
        : spec_(spec), cancel_(cancel), n_(spec.as_written.face_size()) {}

    Audit run() {
        audit_pixels();
        if (spec_.windows > 0) audit_windows();
        return audit_;
    }

  private:
    RandomStream choice_stream(uint64_t part) const {
        return RandomStream(
            random_key({spec_.key, static_cast<uint64_t>(StreamPurpose::kAuditChoice), part}));
    }
    TruthPair truth_of(const CubePixel& stored, uint64_t part, CostStats& stats) const {
        const uint64_t key =
            random_key({spec_.key, static_cast<uint64_t>(StreamPurpose::kAuditTruth), part});
        return spec_.truth(owner_of(stored, n_), key, stats);
    }

    /// Calls measure(i, stats) for i < count in parallel; adds up the costs in order.
    template <class Measure>
    void for_each(size_t count, Measure measure) {
        std::vector<CostStats> stats(count);
        tbb::parallel_for(size_t{0}, count, [&](size_t i) {
            if (cancel_.cancelled()) return;
            const auto start = std::chrono::steady_clock::now();
            measure(i, stats[i]);
            stats[i].seconds =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        });
        cancel_.throw_if_cancelled();
        for (const CostStats& part : stats) audit_.cost += part;
    }

    void audit_pixels() {
        const std::vector<double> probability = draw_probabilities(spec_);
        std::vector<double> cumulative(probability.size());
        double sum = 0.0;
        for (size_t i = 0; i < probability.size(); ++i) cumulative[i] = sum += probability[i];
        RandomStream random = choice_stream(0);
        std::vector<size_t> drawn;
        for (int i = 0; i < spec_.pixels; ++i) {
            const auto at =
                std::upper_bound(cumulative.begin(), cumulative.end(), random.uniform() * sum);
            drawn.push_back(
                std::min(static_cast<size_t>(at - cumulative.begin()), cumulative.size() - 1));
        }
        std::vector<double> errors(drawn.size());
        std::vector<ShDraw> differences(spec_.sh ? drawn.size() : 0);
        for_each(drawn.size(), [&](size_t i, CostStats& stats) {
            const CubePixel pixel = pixel_at(drawn[i], n_);
            const Rgb& value = spec_.as_written.at(pixel);
            const TruthPair truth = truth_of(pixel, i, stats);
            const double error = squared_error(value, truth, spec_.exposure);
            const double inverse =
                1.0 / (static_cast<double>(probability.size()) * probability[drawn[i]]);
            errors[i] = pixel_weight(spec_.weighting, pixel, n_) * error * inverse;
            if (!spec_.sh) return;
            const Vec3 mean = (Vec3(truth.r1) + Vec3(truth.r2)) / 2.0;
            differences[i] = {pixel, (Vec3(value) - mean) / probability[drawn[i]]};
        });
        Moments moments;
        for (const double error : errors) moments.add(error);
        audit_.error.mse = Estimate::of_mean(moments);
        audit_.pixels = drawn.size();
        if (!spec_.sh) return;
        audit_.sh = audit_sh(differences, n_);
        audit_.error.irradiance = relative_irradiance(*audit_.sh, project_sh(spec_.as_written));
    }

    void audit_windows() {
        RandomStream random = choice_stream(1);
        std::vector<CubePixel> corners;
        const auto range = static_cast<uint64_t>(n_ - kSsimWindow_px + 1);
        for (int i = 0; i < spec_.windows; ++i) {
            const CubeFace face = kCubeFaces[random.below(kFaceCount)];
            const int x = static_cast<int>(random.below(range));
            corners.push_back({face, x, static_cast<int>(random.below(range))});
        }
        std::vector<double> values(corners.size());
        for_each(corners.size(), [&](size_t i, CostStats& stats) {
            values[i] = window_ssim(corners[i], static_cast<uint64_t>(spec_.pixels) + i, stats);
        });
        Moments moments;
        for (const double value : values) moments.add(value);
        audit_.error.ssim = Estimate::of_mean(moments);
        audit_.windows = corners.size();
    }

    double window_ssim(const CubePixel& corner, uint64_t part, CostStats& stats) const {
        SsimWindow a;
        SsimWindow r1;
        SsimWindow r2;
        for (int i = 0; i < kSsimWindow_px * kSsimWindow_px; ++i) {
            const CubePixel pixel{corner.face, corner.x + i % kSsimWindow_px,
                                  corner.y + i / kSsimWindow_px};
            const TruthPair truth =
                truth_of(pixel, random_key({part, static_cast<uint64_t>(i)}), stats);
            const auto at = static_cast<size_t>(i);
            a[at] = ssim_luminance(spec_.as_written.at(pixel), spec_.exposure);
            r1[at] = ssim_luminance(truth.r1, spec_.exposure);
            r2[at] = ssim_luminance(truth.r2, spec_.exposure);
        }
        return ssim(a, r1, r2);
    }

    const AuditSpec& spec_;
    const CancelToken& cancel_;
    int n_;
    Audit audit_;
};

}  // namespace

TruthOf voxel_truth(const RenderScene& scene, const Vec3& origin, int n,
                    const TruthParams& params) {
    return [&scene, origin, n, params](const CubePixel& owner, uint64_t key, CostStats& stats) {
        return truth_pair(scene, cube_face_view(owner.face, n, origin), owner.x, owner.y,
                          {.against = params.against, .grid = params.grid, .key = key}, stats);
    };
}

Audit audit_cubemap(const AuditSpec& spec, const CancelToken& cancel) {
    return AuditRun(spec, cancel).run();
}

}  // namespace probebake
