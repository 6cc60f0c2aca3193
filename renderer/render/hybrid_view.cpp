#include "render/hybrid_view.h"

#include <tbb/parallel_for.h>

#include "render/hybrid.h"
#include "render/tile_lists.h"
#include "render/tiles.h"

namespace probebake {
namespace {

/// Of the waiting pixels, how many go on in a round; and the fewest of a round.
constexpr size_t kRoundShare = 4;
constexpr size_t kMinRound = 1024;

/// What is kept of a first ray, beside its colour, until its neighbours have theirs.
struct FirstRays {
    double node_error = 0.0;
    double child_variance = 0.0;
    double passed_contrast = 0.0;
    double t = 0.0;
    uint32_t steps = 0;
    uint32_t box_tests = 0;
    int level = -1;  // −1 for a miss
};

/// A pixel between two stages. Its cost is not counted yet.
struct Waiting {
    int x = 0;
    int y = 0;
    HybridPixel pixel;
    double gain = 0.0;
};

}  // namespace

class HybridView {
  public:
    HybridView(const RenderScene& scene, const View& view, const RenderSettings& settings,
               const CancelToken& cancel, const ViewExtent& extent)
        : scene_(scene),
          view_(view),
          settings_(settings),
          cancel_(cancel),
          extent_(extent),
          lists_(view, settings.hybrid.start_lists) {
        out_.color = Image(view.width_px, view.height_px);
        out_.aux.resize(static_cast<size_t>(view.width_px) * static_cast<size_t>(view.height_px));
        first_.resize(out_.aux.size());
        first_colors_.resize(out_.aux.size());
    }

    /// Casts the first rays and keeps every pixel as it is then, for refine_to.
    void begin() {
        out_.stats += cast_first_rays();
        for (int y = 0; y < view_.height_px; ++y) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!first_colors_[view_.index(x, y)].there) continue;
                const HybridPixel pixel = after_first_ray(x, y);
                out_.stats += pixel.cost;
                store(x, y, pixel);
                kept_.push_back(kept(x, y, pixel));
            }
        }
        first_ = {};
        first_colors_ = {};
    }

    void reveal(std::span<const double> differences) {
        for (Kept& at : kept_) {
            at.evidence.hidden = differences[view_.index(at.x, at.y)];
            const HybridPixel pixel{.stage = at.stage, .sums = at.sums, .evidence = at.evidence};
            store(at.x, at.y, pixel);
            at = kept(at.x, at.y, pixel);
        }
    }

    /// Has every pixel go on that the price, not below 0, or the least grid asks for.
    void refine_to(double price, int least_grid) {
        settings_.price = price;
        settings_.least_grid = least_grid;
        constexpr size_t kBlock = 64;
        const size_t blocks = (kept_.size() + kBlock - 1) / kBlock;
        out_.stats += for_each_row(static_cast<int>(blocks), cancel_, [&](int b, CostStats& stats) {
            const size_t begin = static_cast<size_t>(b) * kBlock;
            for (size_t i = begin; i < std::min(begin + kBlock, kept_.size()); ++i) {
                Kept& at = kept_[i];
                if (!probebake::goes_on(at.stage, at.evidence, settings_)) continue;
                HybridPixel pixel{.stage = at.stage, .sums = at.sums, .evidence = at.evidence};
                while (goes_on(pixel)) cast_stage(cast_at(at.x, at.y), pixel);
                store(at.x, at.y, pixel);
                stats += pixel.cost;
                at = kept(at.x, at.y, pixel);
            }
        });
    }

    double largest_gain() const {
        double largest = 0.0;
        for (const Kept& pixel : kept_) largest = std::max(largest, pixel.gain);
        return largest;
    }

    const ViewRender& render() const { return out_; }

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
    /// A pixel between two refinements. Its cost so far is counted.
    struct Kept {
        int x = 0;
        int y = 0;
        int stage = 0;
        PixelSums sums;
        PixelEvidence evidence;
        double gain = 0.0;
    };

    static Kept kept(int x, int y, const HybridPixel& pixel) {
        return {x,
                y,
                pixel.stage,
                pixel.sums,
                pixel.evidence,
                predicted_gain(pixel.stage, pixel.evidence)};
    }

    bool renders(int x, int y) const { return renders_pixel(extent_.face, x, y, view_.width_px); }

    HybridCast cast_at(int x, int y) const {
        return {scene_, view_, x, y, settings_.hybrid, lists_.at(x, y)};
    }

    /// Seconds and steps of the lists; the rays are counted with their pixels.
    CostStats cast_first_rays() {
        const CostStats pass =
            for_each_row(lists_.tiles(), cancel_, [&](int tile, CostStats& stats) {
                stats.steps += lists_.make(scene_.tree, view_, tile);
                const PixelRect rect = lists_.pixels(view_, tile);
                for (int y = rect.y0; y <= rect.y1; ++y) {
                    for (int x = rect.x0; x <= rect.x1; ++x) {
                        if (renders(x, y)) cast_first_ray(x, y);
                    }
                }
            });
        for (const Neighbour& first : first_colors_) out_.pixels += first.there ? 1 : 0;
        return pass;
    }

    void cast_first_ray(int x, int y) {
        HybridPixel pixel;
        cast_stage(cast_at(x, y), pixel);
        store(x, y, pixel);
        first_colors_[view_.index(x, y)] = {pixel.color(), true};
        FirstRays& first = first_[view_.index(x, y)];
        first = {.node_error = pixel.evidence.node_error[0],
                 .child_variance = pixel.evidence.child_variance[0],
                 .passed_contrast = pixel.evidence.passed_contrast[0],
                 .t = pixel.sums.distance,
                 .steps = static_cast<uint32_t>(pixel.cost.steps),
                 .box_tests = static_cast<uint32_t>(pixel.cost.box_tests)};
        for (size_t level = 0; level < pixel.cost.level_histogram.size(); ++level) {
            if (pixel.cost.level_histogram[level] > 0) first.level = static_cast<int>(level);
        }
    }

    void store(int x, int y, const HybridPixel& pixel) {
        out_.store(x, y, pixel.sums.scaled(1.0 / pixel.sums.samples));
        out_.aux[view_.index(x, y)].predicted_error = static_cast<float>(expected_error(pixel));
    }

    HybridPixel after_first_ray(int x, int y) const {
        const FirstRays& first = first_[view_.index(x, y)];
        HybridPixel pixel{.stage = 0};
        pixel.evidence.contrast = neighbour_contrast(first_colors_, view_, x, y);
        pixel.evidence.node_error[0] = first.node_error;
        pixel.evidence.child_variance[0] = first.child_variance;
        pixel.evidence.passed_contrast[0] = first.passed_contrast;
        pixel.sums.add(scene_, first_colors_[view_.index(x, y)].color, first.t, 1.0);
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
                if (!first_colors_[view_.index(x, y)].there) continue;
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
                if (!first_colors_[view_.index(x, y)].there) continue;
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
    const View view_;
    RenderSettings settings_;
    const CancelToken& cancel_;
    ViewExtent extent_;
    TileLists lists_;
    std::vector<FirstRays> first_;
    std::vector<Neighbour> first_colors_;
    std::vector<Kept> kept_;
    ViewRender out_;
};

ViewRender render_hybrid_view(const RenderScene& scene, const View& view,
                              const RenderSettings& settings, const CancelToken& cancel,
                              const ViewExtent& extent) {
    return HybridView(scene, view, settings, cancel, extent).run();
}

HybridCubemap::HybridCubemap(const RenderScene& scene, const Vec3& origin, int n,
                             const CancelToken& cancel)
    : n_(n) {
    tbb::parallel_for(size_t{0}, views_.size(), [&](size_t f) {
        const CubeFace face = kCubeFaces[f];
        views_[f] = std::make_unique<HybridView>(scene, cube_face_view(face, n, origin),
                                                 hybrid_at(0.0), cancel, ViewExtent{.face = face});
        views_[f]->begin();
    });
}

HybridCubemap::~HybridCubemap() = default;

void HybridCubemap::reveal(const std::vector<double>& differences) {
    const size_t face_pixels = static_cast<size_t>(n_) * static_cast<size_t>(n_);
    for (size_t f = 0; f < views_.size(); ++f) {
        views_[f]->reveal(std::span(differences).subspan(f * face_pixels, face_pixels));
    }
}

void HybridCubemap::refine_to(double price, int least_grid) {
    tbb::parallel_for(size_t{0}, views_.size(),
                      [&](size_t f) { views_[f]->refine_to(price, least_grid); });
}

double HybridCubemap::largest_gain() const {
    double largest = 0.0;
    for (const auto& view : views_) largest = std::max(largest, view->largest_gain());
    return largest;
}

CubemapRender HybridCubemap::render() const {
    std::array<ViewRender, kFaceCount> views;
    for (size_t f = 0; f < views.size(); ++f) views[f] = views_[f]->render();
    return join_faces(n_, views);
}

double HybridCubemap::predicted_sum(const std::vector<double>& weights) const {
    const size_t face_pixels = static_cast<size_t>(n_) * static_cast<size_t>(n_);
    double sum = 0.0;
    for (size_t i = 0; i < weights.size(); ++i) {
        const PixelAux& pixel = views_[i / face_pixels]->render().aux[i % face_pixels];
        sum += weights[i] * static_cast<double>(pixel.predicted_error);
    }
    return sum;
}

}  // namespace probebake
