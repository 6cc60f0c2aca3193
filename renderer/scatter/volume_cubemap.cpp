#include "scatter/volume_cubemap.h"

#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "math/sampling.h"

namespace probebake {
namespace {

/// What is known of a pixel so far.
struct PixelState {
    int samples = 0;
    Vec3 sum{0.0};
    Vec3 sum2{0.0};
    double distance = 0.0;
    double distance2 = 0.0;

    /// Of a path's radiance, per channel.
    Vec3 variance() const {
        if (samples < 2) return Vec3(0.0);
        const Vec3 mean = sum / static_cast<double>(samples);
        const Vec3 v = (sum2 - mean * sum) / (samples - 1.0);
        return glm::max(v, Vec3(0.0));
    }
};

double mean_of(const Vec3& v) { return (v.x + v.y + v.z) / 3.0; }

class Renderer {
  public:
    Renderer(const PathTracer& tracer, const VolumeView& view, const VolumeQuality& quality,
             const CancelToken& cancel)
        : tracer_(tracer),
          view_(view),
          quality_(quality),
          cancel_(cancel),
          n_(view.face_size_px),
          states_(6 * static_cast<size_t>(n_) * static_cast<size_t>(n_)),
          wanted_(states_.size(), 0) {
        for (size_t i = 0; i < states_.size(); ++i) {
            const CubePixel pixel = pixel_at(i, n_);
            if (owner_of(pixel, n_) == pixel) wanted_[i] = quality.first_samples;
        }
    }

    VolumeCubemap run() {
        sample();
        out_.predicted_rmse = predict();
        while (quality_.target_rmse > 0.0 && out_.predicted_rmse > quality_.target_rmse &&
               ask_for_more()) {
            sample();
            out_.predicted_rmse = predict();
            ++out_.rounds;
        }
        out_.target_met = quality_.target_rmse > 0.0 && out_.predicted_rmse <= quality_.target_rmse;
        write();
        return std::move(out_);
    }

  private:
    /// Brings every pixel to its wanted number of samples.
    void sample() {
        const auto n = static_cast<size_t>(n_);
        std::vector<PathCount> counts(6 * n);
        std::vector<double> seconds(counts.size());
        tbb::parallel_for(size_t{0}, counts.size(), [&](size_t row) {
            const auto start = std::chrono::steady_clock::now();
            for (size_t i = row * n; i < (row + 1) * n; ++i) {
                while (states_[i].samples < wanted_[i] && !cancel_.cancelled()) {
                    add_path(i, counts[row]);
                }
            }
            seconds[row] =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        });
        cancel_.throw_if_cancelled();
        for (size_t row = 0; row < counts.size(); ++row) {
            out_.faces[row / n] += counts[row];
            out_.seconds[row / n] += seconds[row];
            paths_ += counts[row].paths;
        }
    }

    void add_path(size_t i, PathCount& count) {
        PixelState& state = states_[i];
        const PixelPath name{random_key({view_.key, i}), static_cast<uint32_t>(state.samples)};
        const PathResult path = pixel_path(tracer_, view_, pixel_at(i, n_), name, count);
        ++state.samples;
        state.sum += path.radiance;
        state.sum2 += path.radiance * path.radiance;
        const double distance = std::min(path.distance_m, view_.range.end);
        state.distance += distance;
        state.distance2 += distance * distance;
    }

    bool owned(size_t i) const { return wanted_[i] > 0; }

    double predict() const {
        double sum = 0.0;
        double pixels = 0.0;
        for (size_t i = 0; i < states_.size(); ++i) {
            if (!owned(i)) continue;
            sum += mean_of(states_[i].variance()) / states_[i].samples;
            pixels += 1.0;
        }
        return std::sqrt(sum / pixels);
    }

    /// Standard deviation of a path as the owned neighbours on the same face have it.
    double neighbours_sigma(size_t i) const {
        const CubePixel pixel = pixel_at(i, n_);
        double sum = 0.0;
        int count = 0;
        for (int y = std::max(0, pixel.y - 1); y <= std::min(n_ - 1, pixel.y + 1); ++y) {
            for (int x = std::max(0, pixel.x - 1); x <= std::min(n_ - 1, pixel.x + 1); ++x) {
                const size_t k = cube_index({pixel.face, x, y}, n_);
                if (k == i || !owned(k)) continue;
                sum += mean_of(states_[k].variance());
                ++count;
            }
        }
        if (count == 0) return std::sqrt(mean_of(states_[i].variance()));
        return std::sqrt(sum / count);
    }

    /// False where no pixel may have more.
    bool ask_for_more() {
        std::vector<double> sigmas(states_.size(), 0.0);
        double sum = 0.0;
        double pixels = 0.0;
        for (size_t i = 0; i < states_.size(); ++i) {
            if (!owned(i)) continue;
            sigmas[i] = neighbours_sigma(i);
            sum += sigmas[i];
            pixels += 1.0;
        }
        // Σ σ²/n = pixels · target² with n = σ · factor; a tenth more, so that few rounds do.
        // Within a budget Σ n is what that leaves.
        double factor = 1.1 * sum / (pixels * quality_.target_rmse * quality_.target_rmse);
        if (quality_.most_paths && sum > 0.0) {
            factor = std::min(factor, static_cast<double>(*quality_.most_paths) / sum);
        }
        std::vector<int> wanted = wanted_;
        uint64_t more = 0;
        for (size_t i = 0; i < states_.size(); ++i) {
            if (!owned(i)) continue;
            const int now = states_[i].samples;
            // At most four times as many in one round: σ may be badly known.
            const double most = std::min(4.0 * now, static_cast<double>(quality_.most_samples));
            wanted[i] =
                std::max(now, static_cast<int>(std::ceil(std::min(sigmas[i] * factor, most))));
            more += static_cast<uint64_t>(wanted[i] - now);
        }
        if (more == 0 && pixels > 0.0) return ask_everywhere();
        return ask_within_budget(wanted, more);
    }

    /// Asks for `more` paths, or for the same share of all of them that the budget pays for.
    bool ask_within_budget(const std::vector<int>& wanted, uint64_t more) {
        const uint64_t left = budget_left();
        const double share =
            more <= left ? 1.0 : static_cast<double>(left) / static_cast<double>(more);
        out_.limited |= share < 1.0;
        bool any = false;
        for (size_t i = 0; i < wanted.size(); ++i) {
            if (!owned(i)) continue;
            const int now = states_[i].samples;
            wanted_[i] = now + static_cast<int>(share * (wanted[i] - now));
            any |= wanted_[i] > now;
        }
        return any;
    }

    /// Where the neighbours say that all is done and the sum says that it is not: twice as many.
    bool ask_everywhere() {
        std::vector<int> wanted = wanted_;
        uint64_t more = 0;
        for (size_t i = 0; i < states_.size(); ++i) {
            if (!owned(i)) continue;
            wanted[i] = std::min(2 * states_[i].samples,
                                 std::max(quality_.most_samples, states_[i].samples));
            more += static_cast<uint64_t>(wanted[i] - states_[i].samples);
        }
        return more > 0 && ask_within_budget(wanted, more);
    }

    uint64_t budget_left() const {
        uint64_t left = std::numeric_limits<uint64_t>::max();
        if (quality_.most_paths) {
            left = *quality_.most_paths - std::min(*quality_.most_paths, paths_);
        }
        if (!quality_.most_seconds) return left;
        const double spent = std::accumulate(out_.seconds.begin(), out_.seconds.end(), 0.0);
        const double paid_for = std::max(0.0, *quality_.most_seconds - spent) *
                                static_cast<double>(paths_) / std::max(1e-9, spent);
        return paid_for < static_cast<double>(left) ? static_cast<uint64_t>(paid_for) : left;
    }

    void write() {
        out_.color = Cubemap(n_);
        out_.pixels.resize(states_.size());
        for (size_t i = 0; i < states_.size(); ++i) {
            const CubePixel pixel = pixel_at(i, n_);
            const PixelState& state = states_[cube_index(owner_of(pixel, n_), n_)];
            const double samples = state.samples;
            out_.color.at(pixel) = Rgb(state.sum / samples);
            out_.pixels[i] = {Rgb(glm::sqrt(state.variance() / samples)), state.distance / samples,
                              state.distance2 / samples, state.samples};
        }
    }

    const PathTracer& tracer_;
    const VolumeView& view_;
    const VolumeQuality& quality_;
    const CancelToken& cancel_;
    int n_;
    std::vector<PixelState> states_;
    std::vector<int> wanted_;  // samples; 0 where another pixel owns this one
    uint64_t paths_ = 0;
    VolumeCubemap out_;
};

}  // namespace

PathCount VolumeCubemap::count() const {
    PathCount sum;
    for (const PathCount& face : faces) sum += face;
    return sum;
}

PathResult pixel_path(const PathTracer& tracer, const VolumeView& view, const CubePixel& pixel,
                      const PixelPath& name, PathCount& count) {
    const auto point = owen_sobol_4d(name.index, name.key);
    const double u = grid_coordinate(pixel.x + point[0] - 0.5, view.face_size_px);
    const double v = grid_coordinate(pixel.y + point[1] - 0.5, view.face_size_px);
    const Ray ray{view.origin_m, glm::normalize(face_direction(pixel.face, u, v))};
    PathRandom random(random_key({name.key, name.index}), {point[2], point[3]}, 2);
    return tracer.trace(ray, view.range, random, count);
}

VolumeCubemap render_volume_cubemap(const PathTracer& tracer, const VolumeView& view,
                                    const VolumeQuality& quality, const CancelToken& cancel) {
    if (view.face_size_px < 1 || quality.first_samples < 2 ||
        quality.most_samples < quality.first_samples || !(quality.target_rmse >= 0.0)) {
        throw std::invalid_argument("volume cubemap: settings out of range");
    }
    return Renderer(tracer, view, quality, cancel).run();
}

}  // namespace probebake
