#include "render/hybrid_view.h"

#include "render/hybrid.h"
#include "render/tiles.h"

namespace probebake {
namespace {

/// Of the waiting pixels, how many go on in a round; and the fewest of a round.
constexpr size_t kRoundShare = 4;
constexpr size_t kMinRound = 1024;
/// Side of a tile, whose rays share a start list.
constexpr int kTile_px = 8;

/// What is kept of a first ray until its neighbours have theirs.
struct FirstRays {
    double node_error = 0.0;
    double child_variance = 0.0;
    double passed_contrast = 0.0;
    double t = 0.0;
    uint32_t steps = 0;
    uint32_t box_tests = 0;
    int level = -1;  // −1 for a miss
    bool rendered = false;
};

/// A pixel between two stages. Its cost is not counted yet.
struct Waiting {
    int x = 0;
    int y = 0;
    HybridPixel pixel;
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
        out_.stats += first_pass;
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

    /// Of the tile that holds a pixel.
    const StartList* list_at(int x, int y) const {
        if (lists_.empty()) return nullptr;
        return &lists_[static_cast<size_t>(y / kTile_px * tiles_across() + x / kTile_px)];
    }
    int tiles_across() const { return (view_.width_px + kTile_px - 1) / kTile_px; }
    int tiles_down() const { return (view_.height_px + kTile_px - 1) / kTile_px; }

    HybridCast cast_at(int x, int y) const {
        return {scene_, view_, x, y, settings_.hybrid, list_at(x, y)};
    }

    /// Seconds and steps of the lists; the rays are counted with their pixels.
    CostStats cast_first_rays() {
        const int tiles = tiles_across() * tiles_down();
        if (settings_.hybrid.start_lists) lists_.resize(static_cast<size_t>(tiles));
        const CostStats pass = for_each_row(tiles, cancel_, [&](int tile, CostStats& stats) {
            const int x0 = tile % tiles_across() * kTile_px;
            const int y0 = tile / tiles_across() * kTile_px;
            const PixelRect rect{x0, y0, std::min(x0 + kTile_px, view_.width_px) - 1,
                                 std::min(y0 + kTile_px, view_.height_px) - 1};
            if (!lists_.empty()) {
                StartList& list = lists_[static_cast<size_t>(tile)];
                list = start_list(scene_.tree, pixel_beam(view_, rect, 1.0));
                stats.steps += list.steps;
            }
            for (int y = rect.y0; y <= rect.y1; ++y) {
                for (int x = rect.x0; x <= rect.x1; ++x) {
                    if (renders(x, y)) cast_first_ray(x, y);
                }
            }
        });
        for (const FirstRays& first : first_) out_.pixels += first.rendered ? 1 : 0;
        return pass;
    }

    void cast_first_ray(int x, int y) {
        HybridPixel pixel;
        cast_stage(cast_at(x, y), pixel);
        store(x, y, pixel);
        first_color_.at(x, y) = pixel.color();
        FirstRays& first = first_[index(x, y)];
        first = {.node_error = pixel.evidence.node_error[0],
                 .child_variance = pixel.evidence.child_variance[0],
                 .passed_contrast = pixel.evidence.passed_contrast[0],
                 .t = pixel.sums.distance,
                 .steps = static_cast<uint32_t>(pixel.cost.steps),
                 .box_tests = static_cast<uint32_t>(pixel.cost.box_tests),
                 .rendered = true};
        for (size_t level = 0; level < pixel.cost.level_histogram.size(); ++level) {
            if (pixel.cost.level_histogram[level] > 0) first.level = static_cast<int>(level);
        }
    }

    void store(int x, int y, const HybridPixel& pixel) {
        out_.store(x, y, pixel.sums.scaled(1.0 / pixel.sums.samples));
        out_.aux[index(x, y)].predicted_error = static_cast<float>(expected_error(pixel));
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

    HybridPixel after_first_ray(int x, int y) const {
        const FirstRays& first = first_[index(x, y)];
        HybridPixel pixel{.stage = 0};
        pixel.evidence.contrast = contrast(x, y);
        pixel.evidence.node_error[0] = first.node_error;
        pixel.evidence.child_variance[0] = first.child_variance;
        pixel.evidence.passed_contrast[0] = first.passed_contrast;
        pixel.sums.add(first_color_.at(x, y), first.t, scene_.range.t_max, 1.0);
        Hit hit;
        hit.level = first.level;
        hit.steps = first.steps;
        hit.box_tests = first.box_tests;
        pixel.cost.keep(hit);
        return pixel;
    }

    bool goes_on(const HybridPixel& pixel) const {
        return probebake::goes_on(pixel.stage, pixel.evidence, settings_);
    }

    void refine_all() {
        out_.stats = for_each_row(view_.height_px, cancel_, [&](int y, CostStats& stats) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!first_[index(x, y)].rendered) continue;
                HybridPixel pixel = after_first_ray(x, y);
                while (goes_on(pixel)) cast_stage(cast_at(x, y), pixel);
                store(x, y, pixel);
                stats += pixel.cost;
            }
        });
    }

    void refine_within(uint64_t ray_limit) {
        std::vector<Waiting> waiting;
        uint64_t spent = out_.pixels;
        const auto wait_or_count = [&](Waiting& at) {
            if (goes_on(at.pixel)) {
                at.gain = predicted_gain(at.pixel.stage, at.pixel.evidence);
                waiting.push_back(at);
            } else {
                out_.stats += at.pixel.cost;
            }
        };
        for (int y = 0; y < view_.height_px; ++y) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!first_[index(x, y)].rendered) continue;
                Waiting at{x, y, after_first_ray(x, y)};
                wait_or_count(at);
            }
        }
        while (!waiting.empty()) {
            std::stable_sort(waiting.begin(), waiting.end(),
                             [](const Waiting& a, const Waiting& b) { return a.gain > b.gain; });
            const size_t wanted =
                std::min(waiting.size(), std::max(kMinRound, waiting.size() / kRoundShare));
            size_t count = 0;
            for (; count < wanted; ++count) {
                const uint64_t rays = next_rays(waiting[count].pixel);
                if (spent + rays > ray_limit) break;
                spent += rays;
            }
            if (count == 0) break;
            std::vector<Waiting> round(waiting.begin(),
                                       waiting.begin() + static_cast<std::ptrdiff_t>(count));
            waiting.erase(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(count));
            out_.stats += for_each_row(static_cast<int>(count), cancel_, [&](int i, CostStats&) {
                Waiting& at = round[static_cast<size_t>(i)];
                cast_stage(cast_at(at.x, at.y), at.pixel);
                store(at.x, at.y, at.pixel);
            });
            for (Waiting& at : round) wait_or_count(at);
        }
        out_.limited = !waiting.empty();
        for (const Waiting& at : waiting) out_.stats += at.pixel.cost;
    }

    uint64_t next_rays(const HybridPixel& pixel) const {
        const int grid = stage_grid(pixel.stage + 1);
        return static_cast<uint64_t>(settings_.hybrid.nested_rays ? stage_rays(pixel.stage + 1)
                                                                  : grid * grid);
    }

    const RenderScene& scene_;
    const View& view_;
    const RenderSettings& settings_;
    const CancelToken& cancel_;
    ViewExtent extent_;
    std::vector<StartList> lists_;  // of tiles, row by row
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
