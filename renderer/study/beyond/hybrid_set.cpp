#include "study/beyond/hybrid_set.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "math/sampling.h"

namespace probebake::study {
namespace {

constexpr int kTile_px = 8;
constexpr uint32_t kTruthRays = 256;
/// Prices are sought between these powers of ten.
constexpr double kLowestPrice = -20.0;
constexpr double kHighestPrice = 10.0;
constexpr int kHalvings = 30;
constexpr size_t kPart = 8192;
constexpr uint64_t kTruthPlaces = 0x74727574'68000000;

/// Pixels of a view before the neighbours' contrast is known.
struct FirstPass {
    std::vector<StartList> lists;
    std::vector<Neighbour> first;
};

class Recorder {
  public:
    Recorder(const RenderScene& scene, const FaceView& at, const HybridSwitches& switches)
        : scene_(scene), at_(at), switches_(switches), width_(at.view.width_px) {}

    /// Adds the pixels of the view and returns the steps of its start lists.
    uint64_t record(const Image& truth, std::vector<RecordedPixel>& pixels) {
        make_lists();
        const size_t count = truth.pixels().size();
        first_.assign(count, {});
        std::vector<HybridPixel> states(count);
        tbb::parallel_for(0, at_.view.height_px, [&](int y) {
            for (int x = 0; x < width_; ++x) {
                if (!at_.renders(x, y)) continue;
                cast_stage(cast_at(x, y), states[index(x, y)]);
                first_[index(x, y)] = {states[index(x, y)].color(), true};
            }
        });
        std::vector<RecordedPixel> recorded(count);
        tbb::parallel_for(0, at_.view.height_px, [&](int y) {
            for (int x = 0; x < width_; ++x) {
                if (!at_.renders(x, y)) continue;
                RecordedPixel& pixel = recorded[index(x, y)];
                finish(x, y, states[index(x, y)], pixel);
                pixel.truth = Vec3(truth.at(x, y));
            }
        });
        for (size_t i = 0; i < count; ++i) {
            if (first_[i].there) pixels.push_back(recorded[i]);
        }
        uint64_t steps = 0;
        for (const StartList& list : lists_) steps += list.steps;
        return steps;
    }

  private:
    size_t index(int x, int y) const {
        return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
    }
    int tiles_across() const { return (width_ + kTile_px - 1) / kTile_px; }

    void make_lists() {
        if (!switches_.start_lists) return;
        const int tiles_down = (at_.view.height_px + kTile_px - 1) / kTile_px;
        lists_.resize(static_cast<size_t>(tiles_across() * tiles_down));
        tbb::parallel_for(size_t{0}, lists_.size(), [&](size_t tile) {
            const int x0 = static_cast<int>(tile) % tiles_across() * kTile_px;
            const int y0 = static_cast<int>(tile) / tiles_across() * kTile_px;
            const PixelRect rect{x0, y0, std::min(x0 + kTile_px, width_) - 1,
                                 std::min(y0 + kTile_px, at_.view.height_px) - 1};
            lists_[tile] = start_list(scene_.tree, pixel_beam(at_.view, rect, 1.0));
        });
    }

    HybridCast cast_at(int x, int y) const {
        const StartList* from =
            lists_.empty()
                ? nullptr
                : &lists_[static_cast<size_t>(y / kTile_px * tiles_across() + x / kTile_px)];
        return {scene_, at_.view, x, y, switches_, from};
    }

    double contrast(int x, int y) const {
        std::array<Neighbour, 9> block;
        for (int i = 0; i < 9; ++i) {
            const int nx = x + i % 3 - 1;
            const int ny = y + i / 3 - 1;
            if (nx < 0 || ny < 0 || nx >= width_ || ny >= at_.view.height_px) continue;
            block[static_cast<size_t>(i)] = first_[index(nx, ny)];
        }
        return neighbour_contrast(block);
    }

    void finish(int x, int y, HybridPixel& state, RecordedPixel& pixel) const {
        state.evidence.contrast = contrast(x, y);
        for (int stage = 0; stage < kRecordedStages; ++stage) {
            if (stage > 0) cast_stage(cast_at(x, y), state);
            pixel.stages[static_cast<size_t>(stage)] = {
                state.sums.scaled(1.0 / state.sums.samples).color,
                static_cast<uint32_t>(state.cost.all_rays()),
                static_cast<uint32_t>(state.cost.steps),
                static_cast<uint32_t>(state.cost.box_tests)};
        }
        pixel.evidence = state.evidence;
    }

    const RenderScene& scene_;
    const FaceView& at_;
    const HybridSwitches& switches_;
    int width_;
    std::vector<StartList> lists_;
    std::vector<Neighbour> first_;
};

}  // namespace

bool FaceView::renders(int x, int y) const {
    if (!face) return true;
    const CubePixel pixel{*face, x, y};
    return owner_of(pixel, view.width_px) == pixel;
}

std::vector<FaceView> cubemap_views(std::span<const Vec3> positions, int n) {
    std::vector<FaceView> views;
    for (const Vec3& position : positions) {
        for (const CubeFace face : kCubeFaces) {
            views.push_back({cube_face_view(face, n, position), face});
        }
    }
    return views;
}

double RecordedPixel::squared_error(int stage) const {
    const Vec3 difference = stages[static_cast<size_t>(stage)].color - truth;
    return glm::dot(difference, difference) / 3.0;
}

Score model_score(const ErrorModel& model) {
    return [model](const RecordedPixel& pixel, int stage) {
        return predicted_error(stage, pixel.evidence, model) / stage_rays(stage + 1);
    };
}

Score node_error_score() {
    return [](const RecordedPixel& pixel, int stage) {
        return pixel.evidence.node_error[static_cast<size_t>(std::min(stage, 1))] /
               stage_rays(stage + 1);
    };
}

Score contrast_score() {
    return [](const RecordedPixel& pixel, int stage) {
        return pixel.evidence.contrast / stage_rays(stage + 1);
    };
}

Score perfect_score() {
    return [](const RecordedPixel& pixel, int stage) {
        double best = 0.0;
        double rays = 0.0;
        for (int next = stage + 1; next < kRecordedStages; ++next) {
            rays += stage_rays(next);
            best = std::max(best, (pixel.squared_error(stage) - pixel.squared_error(next)) / rays);
        }
        return best;
    };
}

double HybridOutcome::rmse() const { return std::sqrt(mse); }

HybridSet::HybridSet(const RenderScene& scene, std::span<const FaceView> views,
                     std::span<const Image> truth, const HybridSwitches& switches) {
    for (size_t i = 0; i < views.size(); ++i) {
        list_steps_ += Recorder(scene, views[i], switches).record(truth[i], pixels_);
    }
}

HybridOutcome HybridSet::outcome(const Score& score, double price) const {
    // Parts of fixed size, added up in order: the same sum for any number of threads.
    std::vector<HybridOutcome> parts((pixels_.size() + kPart - 1) / kPart);
    tbb::parallel_for(size_t{0}, parts.size(), [&](size_t p) {
        const size_t end = std::min(pixels_.size(), (p + 1) * kPart);
        for (size_t i = p * kPart; i < end; ++i) {
            const RecordedPixel& pixel = pixels_[i];
            int stage = 0;
            while (stage + 1 < kRecordedStages && score(pixel, stage) > price) ++stage;
            const RecordedPixel::Stage& at = pixel.stages[static_cast<size_t>(stage)];
            parts[p].mse += pixel.squared_error(stage);
            parts[p].rays += at.rays;
            parts[p].steps += at.steps;
            parts[p].box_tests += at.box_tests;
        }
    });
    HybridOutcome out{.pixels = pixels_.size(), .steps = list_steps_};
    for (const HybridOutcome& part : parts) {
        out.mse += part.mse;
        out.rays += part.rays;
        out.steps += part.steps;
        out.box_tests += part.box_tests;
    }
    out.mse /= static_cast<double>(std::max<size_t>(1, pixels_.size()));
    return out;
}

HybridOutcome HybridSet::within_steps(const Score& score, uint64_t steps) const {
    const HybridOutcome all = outcome(score, -1.0);
    if (all.steps <= steps) return all;
    HybridOutcome best = outcome(score, std::pow(10.0, kHighestPrice));
    double high = kHighestPrice;
    double low = kLowestPrice;
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (low + high);
        const HybridOutcome at = outcome(score, std::pow(10.0, middle));
        (at.steps <= steps ? high : low) = middle;
        if (at.steps <= steps) best = at;
    }
    return best;
}

double HybridSet::price_for_error(const Score& score, double rmse) const {
    if (outcome(score, -1.0).rmse() > rmse) return -1.0;
    double high = kHighestPrice;
    double low = kLowestPrice;
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (low + high);
        (outcome(score, std::pow(10.0, middle)).rmse() <= rmse ? low : high) = middle;
    }
    return std::pow(10.0, low);
}

Image nested_truth(const RenderScene& scene, const FaceView& at) {
    Image image(at.view.width_px, at.view.height_px);
    tbb::parallel_for(0, at.view.height_px, [&](int y) {
        for (int x = 0; x < at.view.width_px; ++x) {
            if (!at.renders(x, y)) continue;
            const StartList from = start_list(scene.tree, pixel_beam(at.view, {x, y, x, y}, 1.0));
            const uint64_t key =
                random_key({kTruthPlaces, static_cast<uint64_t>(x), static_cast<uint64_t>(y)});
            Vec3 sum(0.0);
            for (uint32_t i = 0; i < kTruthRays; ++i) {
                const Vec2 place = owen_sobol(i, key) - Vec2(0.5);
                const PixelRay ray = pixel_ray(at.view, x + place.x, y + place.y);
                Hit hit = trace(scene.tree, from, ray.ray, scene.range);
                sum += Vec3(shade(scene, ray.ray.direction, hit));
            }
            image.at(x, y) = Rgb(sum / double{kTruthRays});
        }
    });
    return image;
}

}  // namespace probebake::study
