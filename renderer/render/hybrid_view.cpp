#include "render/hybrid_view.h"

#include "render/hybrid.h"
#include "render/tiles.h"

namespace probebake {
namespace {

/// Of the waiting pixels, how many go on in a round; and the fewest of a round.
constexpr size_t kRoundShare = 4;
constexpr size_t kMinRound = 1024;

/// What is kept of a first ray until its neighbours have theirs.
struct FirstRays {
    double node_error = 0.0;
    double child_variance = 0.0;
    double passed_contrast = 0.0;
    uint32_t steps = 0;
    int8_t level = -1;  // −1 for a miss
    bool rendered = false;
};

/// A pixel between two stages.
struct Pixel {
    int x = 0;
    int y = 0;
    int stage = 0;
    PixelEvidence evidence;
    CostStats cost;  // of this stage, not counted yet
    double gain = 0.0;
};

class HybridView {
  public:
    HybridView(const RenderScene& scene, const View& view, const RenderSettings& settings,
               const CancelToken& cancel, const ViewExtent& extent)
        : scene_(scene), view_(view), settings_(settings), cancel_(cancel), extent_(extent) {
        out_.color = Image(view.width_px, view.height_px);
        out_.aux.resize(static_cast<size_t>(view.width_px) * static_cast<size_t>(view.height_px));
        first_.resize(out_.aux.size());
        first_color_ = out_.color;
    }

    ViewRender run() {
        const CostStats first_pass = cast_first_rays();
        if (extent_.ray_limit) {
            refine_within(*extent_.ray_limit);
        } else {
            refine_all();
        }
        out_.stats.seconds += first_pass.seconds;
        return std::move(out_);
    }

  private:
    bool renders(int x, int y) const {
        if (!extent_.face) return true;
        const CubePixel pixel{*extent_.face, x, y};
        return owner_of(pixel, view_.width_px) == pixel;
    }
    size_t index(int x, int y) const {
        return static_cast<size_t>(y) * static_cast<size_t>(view_.width_px) +
               static_cast<size_t>(x);
    }

    CostStats cast_first_rays() {
        const CostStats pass = for_each_row(view_.height_px, cancel_, [&](int y, CostStats&) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!renders(x, y)) continue;
                const HybridStage found = hybrid_stage(scene_, view_, x, y, 0);
                out_.store(x, y, found.sums);
                first_color_.at(x, y) = found.sums.mean();
                first_[index(x, y)] = {
                    found.node_error,      found.child_variance,
                    found.passed_contrast, static_cast<uint32_t>(found.cost.steps),
                    found.level,           true};
            }
        });
        for (const FirstRays& first : first_) out_.pixels += first.rendered ? 1 : 0;
        return pass;
    }

    double contrast(int x, int y) const {
        std::array<Neighbour, 9> block;
        for (int j = 0; j < 3; ++j) {
            for (int i = 0; i < 3; ++i) {
                const int nx = x + i - 1;
                const int ny = y + j - 1;
                if (nx < 0 || ny < 0 || nx >= view_.width_px || ny >= view_.height_px) continue;
                block[static_cast<size_t>(3 * j + i)] = {first_color_.at(nx, ny),
                                                         first_[index(nx, ny)].rendered};
            }
        }
        return neighbour_contrast(block);
    }

    Pixel after_first_ray(int x, int y) const {
        const FirstRays& first = first_[index(x, y)];
        Pixel pixel{.x = x, .y = y};
        pixel.evidence.contrast = contrast(x, y);
        pixel.evidence.node_error[0] = first.node_error;
        pixel.evidence.child_variance[0] = first.child_variance;
        pixel.evidence.passed_contrast[0] = first.passed_contrast;
        Hit hit;
        hit.level = first.level;
        hit.steps = first.steps;
        pixel.cost.keep(hit);
        return pixel;
    }

    bool goes_on(const Pixel& pixel) const {
        return probebake::goes_on(pixel.stage, pixel.evidence, pixel.cost.steps, settings_);
    }

    /// Casts a pixel's next stage in place of the present one.
    void advance(Pixel& pixel, CostStats& stats) {
        stats.discard_all(pixel.cost);
        const HybridStage found = hybrid_stage(scene_, view_, pixel.x, pixel.y, ++pixel.stage);
        add_evidence(pixel.evidence, pixel.stage, found);
        pixel.cost = found.cost;
        out_.store(pixel.x, pixel.y, found.sums);
    }

    void refine_all() {
        out_.stats = for_each_row(view_.height_px, cancel_, [&](int y, CostStats& stats) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!first_[index(x, y)].rendered) continue;
                Pixel pixel = after_first_ray(x, y);
                while (goes_on(pixel)) advance(pixel, stats);
                stats += pixel.cost;
            }
        });
    }

    void refine_within(uint64_t ray_limit) {
        std::vector<Pixel> waiting;
        uint64_t spent = out_.pixels;
        const auto wait_or_count = [&](Pixel& pixel) {
            if (goes_on(pixel)) {
                pixel.gain = predicted_gain(pixel.stage, pixel.evidence, pixel.cost.steps);
                waiting.push_back(pixel);
            } else {
                out_.stats += pixel.cost;
            }
        };
        for (int y = 0; y < view_.height_px; ++y) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!first_[index(x, y)].rendered) continue;
                Pixel pixel = after_first_ray(x, y);
                wait_or_count(pixel);
            }
        }
        while (!waiting.empty()) {
            std::stable_sort(waiting.begin(), waiting.end(),
                             [](const Pixel& a, const Pixel& b) { return a.gain > b.gain; });
            const size_t wanted =
                std::min(waiting.size(), std::max(kMinRound, waiting.size() / kRoundShare));
            size_t count = 0;
            for (; count < wanted; ++count) {
                const auto grid = static_cast<uint64_t>(stage_grid(waiting[count].stage + 1));
                if (spent + grid * grid > ray_limit) break;
                spent += grid * grid;
            }
            if (count == 0) break;
            std::vector<Pixel> round(waiting.begin(),
                                     waiting.begin() + static_cast<std::ptrdiff_t>(count));
            waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(count));
            out_.stats += for_each_row(static_cast<int>(count), cancel_, [&](int i, CostStats& s) {
                advance(round[static_cast<size_t>(i)], s);
            });
            for (Pixel& pixel : round) wait_or_count(pixel);
        }
        out_.limited = !waiting.empty();
        for (const Pixel& pixel : waiting) out_.stats += pixel.cost;
    }

    const RenderScene& scene_;
    const View& view_;
    const RenderSettings& settings_;
    const CancelToken& cancel_;
    ViewExtent extent_;
    std::vector<FirstRays> first_;
    Image first_color_;
    ViewRender out_;
};

}  // namespace

ViewRender render_hybrid_view(const RenderScene& scene, const View& view,
                              const RenderSettings& settings, const CancelToken& cancel,
                              const ViewExtent& extent) {
    return HybridView(scene, view, settings, cancel, extent).run();
}

}  // namespace probebake
