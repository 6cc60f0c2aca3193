#include "study/beyond/scene_comparison.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "error/node_error.h"
#include "math/sh.h"
#include "render/render.h"
#include "scene/suggest_probes.h"
#include "study/record_set.h"
#include "study/study_scenes.h"

namespace probebake::study {
namespace {

constexpr int kFace_px = 64;
constexpr uint64_t kProbeSeed = 2020;

struct ViewSet {
    std::vector<FaceView> views;
    std::vector<Image> truth;
};

ViewSet with_truth(const RenderScene& scene, std::vector<FaceView> views) {
    ViewSet set{.views = std::move(views)};
    for (const FaceView& view : set.views) set.truth.push_back(nested_truth(scene, view));
    return set;
}

std::vector<Vec3> probe_positions(const Scene& scene, int count) {
    std::vector<Vec3> positions;
    for (const Vec3& p : suggest_probes(scene, count, kProbeSeed)) {
        positions.push_back(scene.to_voxels(p));
    }
    return positions;
}

/// The renderers of the thesis on the same views, from rays cast once.
class ThesisSet {
  public:
    ThesisSet(const RenderScene& scene, const ViewSet& set) : set_(set) {
        for (const FaceView& at : set.views) {
            records_.push_back(record_view(scene, at.view, {.face = at.face}));
        }
        base_steps_ = outcome(lod_outcome).steps;
    }

    struct Result {
        uint64_t steps = 0;
        double rmse = 0.0;
    };
    uint64_t base_steps() const { return base_steps_; }

    Result outcome(const Outcome& of) const {
        std::vector<Part> parts;  // a row of a view each, added up in order
        for (const ViewRecord& record : records_) {
            parts.resize(parts.size() + static_cast<size_t>(record.view.height_px));
        }
        const auto height = static_cast<size_t>(records_[0].view.height_px);
        tbb::parallel_for(size_t{0}, parts.size(), [&](size_t row) {
            const size_t v = row / height;
            const auto width = static_cast<size_t>(records_[v].view.width_px);
            const size_t begin = row % height * width;
            for (size_t i = begin; i < begin + width; ++i) {
                const PixelRecord& pixel = records_[v].pixels[i];
                if (!pixel.rendered) continue;
                const PixelOutcome made = of(pixel);
                const Vec3 difference = made.color - Vec3(set_.truth[v].pixels()[i]);
                parts[row].squared += glm::dot(difference, difference) / 3.0;
                parts[row].steps += made.steps;
                ++parts[row].pixels;
            }
        });
        Part sum;
        for (const Part& part : parts) {
            sum.squared += part.squared;
            sum.steps += part.steps;
            sum.pixels += part.pixels;
        }
        return {sum.steps, std::sqrt(sum.squared / static_cast<double>(sum.pixels))};
    }

    /// The best of a renderer for so many steps: settings from no refinement to all.
    Result error_aware_within(uint64_t steps) const {
        return best_within(steps, [](double x) -> Outcome {
            const double threshold = -0.25 + 1.75 * x;  // E_N with decay 0.2, and some room
            return [threshold](const PixelRecord& pixel) {
                return error_aware_outcome(pixel, threshold, kThesisDecay);
            };
        });
    }
    Result adaptive_within(uint64_t steps, MissesInKernel misses) const {
        return best_within(steps, [misses](double x) -> Outcome {
            const double normaliser = std::exp2(-60.0 + 90.0 * x);
            return [normaliser, misses](const PixelRecord& pixel) {
                return adaptive_outcome(pixel, normaliser, misses);
            };
        });
    }
    /// The fewest steps with which its error-aware renderer errs no more than in `known`.
    uint64_t error_aware_steps_for(const Result& known) const {
        uint64_t fewest = known.steps;
        for (int i = 0; i <= 100; ++i) {
            const double threshold = -0.25 + 1.75 * i / 100.0;
            const Result at = outcome([threshold](const PixelRecord& pixel) {
                return error_aware_outcome(pixel, threshold, kThesisDecay);
            });
            if (at.rmse <= known.rmse) fewest = std::min(fewest, at.steps);
        }
        return fewest;
    }

  private:
    struct Part {
        double squared = 0.0;
        uint64_t steps = 0;
        uint64_t pixels = 0;
    };

    /// `make(x)`: cheaper as x grows from 0 to 1. The smallest affordable x, by halving.
    template <class Make>
    Result best_within(uint64_t steps, Make make) const {
        Result best = outcome(make(0.0));
        if (best.steps <= steps) return best;
        best = outcome(lod_outcome);
        double low = 0.0;
        double high = 1.0;
        for (int i = 0; i < 30; ++i) {
            const double middle = 0.5 * (low + high);
            const Result at = outcome(make(middle));
            (at.steps <= steps ? high : low) = middle;
            if (at.steps <= steps) best = at;
        }
        return best;
    }

    const ViewSet& set_;
    std::vector<ViewRecord> records_;
    uint64_t base_steps_ = 0;
};

Json write_outcome(const HybridOutcome& outcome) {
    return {{"rmse", outcome.rmse()},
            {"rays", outcome.rays},
            {"steps", outcome.steps},
            {"box_tests", outcome.box_tests}};
}

Json compare_set(const ThesisSet& thesis, const HybridSet& hybrid) {
    const Score score = model_score();
    const auto budget = [&](double times) {
        return static_cast<uint64_t>(times * static_cast<double>(thesis.base_steps()));
    };
    Json rows = Json::array();
    for (const double times : kBeyondBudgets) {
        rows.push_back(
            {{"times_base", times},
             {"error_aware", thesis.error_aware_within(budget(times)).rmse},
             {"adaptive", thesis.adaptive_within(budget(times), MissesInKernel::kLeftOut).rmse},
             {"adaptive_black", thesis.adaptive_within(budget(times), MissesInKernel::kBlack).rmse},
             {"hybrid", write_outcome(hybrid.within_steps(score, budget(times)))},
             {"perfect", hybrid.within_steps(perfect_score(), budget(times)).rmse()}});
    }
    const ThesisSet::Result wanted = thesis.error_aware_within(budget(4.0));
    const HybridOutcome reached = hybrid.outcome(score, hybrid.price_for_error(score, wanted.rmse));
    return {{"pixels", hybrid.pixels().size()},
            {"base_steps", thesis.base_steps()},
            {"rows", std::move(rows)},
            {"same_error",
             {{"rmse", wanted.rmse},
              {"thesis_steps", thesis.error_aware_steps_for(wanted)},
              {"hybrid", write_outcome(reached)}}}};
}

/// What the renderer reaches at twice the base without one of its parts, and with others in their
/// place.
Json ablation_on(const RenderScene& scene, const ViewSet& set, const ThesisSet& thesis,
                 const HybridSet& whole) {
    const auto steps = static_cast<uint64_t>(2.0 * static_cast<double>(thesis.base_steps()));
    const auto more = static_cast<uint64_t>(4.0 * static_cast<double>(thesis.base_steps()));
    Json rows = Json::array();
    const auto add = [&](const char* name, const HybridSet& with, const Score& score) {
        rows.push_back({{"variant", name},
                        {"rmse_2", with.within_steps(score, steps).rmse()},
                        {"rmse_4", with.within_steps(score, more).rmse()}});
    };
    {
        const HybridSet plain(scene, set.views, set.truth,
                              {.start_lists = false, .nested_rays = false});
        add("leaf visibility, LOD colour; refined by node error", plain, node_error_score());
        add("... by contrast", plain, contrast_score());
        add("... by the error model", plain, model_score());
    }
    {
        const HybridSet nested(scene, set.views, set.truth, {.start_lists = false});
        add("+ nested rays", nested, model_score());
    }
    add("+ start lists: the renderer", whole, model_score());
    add("the renderer, by node error", whole, node_error_score());
    add("the renderer, by contrast", whole, contrast_score());
    add("the renderer, perfect scores", whole, perfect_score());
    for (const auto& [name, levels] :
         {std::pair{"the renderer, colours one level finer", 1},
          std::pair{"the renderer, colours of the leaves", kMaxDepth}}) {
        RenderScene finer = scene;
        finer.finer_levels = levels;
        add(name, HybridSet(finer, set.views, set.truth, {}), model_score());
    }
    return rows;
}

/// RMS over directions and channels of the difference of irradiance, of order 2, relative to the
/// root mean square of the truth's.
double irradiance_error(std::span<const Cubemap> of, std::span<const Cubemap> truth) {
    constexpr std::array<double, 3> kCosine = {std::numbers::pi, 2.0 * std::numbers::pi / 3.0,
                                               std::numbers::pi / 4.0};
    double difference = 0.0;
    double whole = 0.0;
    for (size_t p = 0; p < of.size(); ++p) {
        std::array<Vec3, kShCount> a{};
        std::array<Vec3, kShCount> b{};
        const int n = of[p].face_size();
        for (const CubeFace face : kCubeFaces) {
            const View view = cube_face_view(face, n, Vec3(0.0));
            for (int y = 0; y < n; ++y) {
                for (int x = 0; x < n; ++x) {
                    const CubePixel pixel{face, x, y};
                    const Sh9 basis = sh_basis(glm::normalize(view.direction(x, y)));
                    const double w = pixel_solid_angle(x, y, n);
                    for (size_t i = 0; i < kShCount; ++i) {
                        a[i] += w * basis[i] * Vec3(of[p].at(pixel));
                        b[i] += w * basis[i] * Vec3(truth[p].at(pixel));
                    }
                }
            }
        }
        for (size_t i = 0; i < kShCount; ++i) {
            const double cosine = kCosine[i == 0 ? 0 : i < 4 ? 1 : 2];
            difference += cosine * cosine * glm::dot(a[i] - b[i], a[i] - b[i]);
            whole += cosine * cosine * glm::dot(b[i], b[i]);
        }
    }
    return whole > 0.0 ? std::sqrt(difference / whole) : 0.0;
}

std::vector<Cubemap> cubemaps_of(std::span<const Image> faces) {
    std::vector<Cubemap> cubes;
    for (size_t i = 0; i < faces.size(); i += kFaceCount) {
        Cubemap cube(faces[i].width());
        for (const CubeFace face : kCubeFaces) {
            const Image& image = faces[i + static_cast<size_t>(index_of(face))];
            for (int y = 0; y < image.height(); ++y) {
                for (int x = 0; x < image.width(); ++x) {
                    cube.at({face, x, y}) = image.at(x, y);
                }
            }
        }
        cube.share_edges();
        cubes.push_back(std::move(cube));
    }
    return cubes;
}

/// One leaf ray per pixel, and its steps from the root and from start lists.
Json irradiance_of(const RenderScene& scene, const ViewSet& set, const ThesisSet& thesis,
                   std::span<const Vec3> positions) {
    std::vector<Cubemap> one_ray;
    CostStats from_root;
    for (const Vec3& position : positions) {
        const CubemapRender render = render_cubemap(
            scene, position, kFace_px, {.kind = RendererKind::kReference, .leaf_grid = 1}, {});
        one_ray.push_back(render.color);
        from_root += render.total();
    }
    const std::vector<Cubemap> truth = cubemaps_of(set.truth);
    return {{"error", irradiance_error(one_ray, truth)},
            {"steps_per_base",
             static_cast<double>(from_root.steps) / static_cast<double>(thesis.base_steps())}};
}

/// Seconds of one thread for the same error on the probes, taken in turns: the thesis's renderer at
/// 4 × base and the hybrid with and without start lists.
Json time_for_same_error(const RenderScene& scene, const ViewSet& set, const ThesisSet& thesis,
                         const HybridSet& hybrid, std::span<const Vec3> positions) {
    const auto steps = static_cast<uint64_t>(4.0 * static_cast<double>(thesis.base_steps()));
    double threshold = -0.25;
    for (double t = 1.5; t > -0.25; t -= 1.75 / 400.0) {
        const auto at = thesis.outcome(
            [t](const PixelRecord& pixel) { return error_aware_outcome(pixel, t, kThesisDecay); });
        if (at.steps > steps) break;
        threshold = t;
    }
    const auto wanted = thesis.outcome([threshold](const PixelRecord& pixel) {
        return error_aware_outcome(pixel, threshold, kThesisDecay);
    });
    const double price = hybrid.price_for_error(model_score(), wanted.rmse);
    const RenderSettings error_aware{.threshold = threshold};
    const RenderSettings listed{.kind = RendererKind::kHybrid, .leaf_grid = 8, .price = price};
    const RenderSettings plain{.kind = RendererKind::kHybrid,
                               .leaf_grid = 8,
                               .price = price,
                               .hybrid = {.start_lists = false}};
    constexpr int kRuns = 3;
    std::array<std::array<double, kRuns>, 3> seconds{};
    std::array<double, 3> rmse{};
    const std::vector<Cubemap> truth = cubemaps_of(set.truth);
    for (size_t run = 0; run < kRuns; ++run) {
        size_t which = 0;
        for (const RenderSettings* settings : {&error_aware, &listed, &plain}) {
            double squared = 0.0;
            for (size_t p = 0; p < positions.size(); ++p) {
                const CubemapRender render =
                    render_cubemap(scene, positions[p], kFace_px, *settings, {});
                seconds[which][run] += render.total().seconds;
                const std::span<const Rgb> a = render.color.image().pixels();
                const std::span<const Rgb> b = truth[p].image().pixels();
                for (size_t i = 0; i < a.size(); ++i) {
                    const Vec3 difference(a[i] - b[i]);
                    squared += glm::dot(difference, difference) / 3.0;
                }
            }
            const auto pixels =
                static_cast<double>(positions.size() * kFaceCount) * kFace_px * kFace_px;
            rmse[which++] = std::sqrt(squared / pixels);
        }
    }
    const auto median = [&](size_t which) {
        std::sort(seconds[which].begin(), seconds[which].end());
        return seconds[which][kRuns / 2];
    };
    const double thesis_seconds = median(0);
    return {{"threshold", threshold},
            {"price", price},
            {"hybrid_over_thesis", median(1) / thesis_seconds},
            {"without_lists_over_thesis", median(2) / thesis_seconds},
            {"rmse", {rmse[0], rmse[1], rmse[2]}}};
}

}  // namespace

Json compare_on_scene(const Scene& scene, const ComparisonParams& params) {
    const RenderScene rendered = albedo_of(scene);
    Json result = {{"voxels", scene.tree.voxel_count()}};
    {
        const ViewSet nadir = with_truth(rendered, {{study_view(scene, params.size), {}}});
        result["nadir"] = compare_set(ThesisSet(rendered, nadir),
                                      HybridSet(rendered, nadir.views, nadir.truth, {}));
    }
    const std::vector<Vec3> positions = probe_positions(scene, params.probes);
    const ViewSet probes = with_truth(rendered, cubemap_views(positions, kFace_px));
    const ThesisSet thesis(rendered, probes);
    const HybridSet hybrid(rendered, probes.views, probes.truth, {});
    result["probes"] = compare_set(thesis, hybrid);
    result["irradiance"] = irradiance_of(rendered, probes, thesis, positions);
    result["time"] = time_for_same_error(rendered, probes, thesis, hybrid, positions);
    if (params.ablation) result["ablation"] = ablation_on(rendered, probes, thesis, hybrid);
    return result;
}

std::vector<RecordedPixel> pixels_to_fit(const Scene& scene, const ComparisonParams& params) {
    const RenderScene rendered = albedo_of(scene);
    std::vector<FaceView> views = cubemap_views(probe_positions(scene, params.probes), kFace_px);
    views.push_back({study_view(scene, params.size), {}});
    const ViewSet set = with_truth(rendered, std::move(views));
    const HybridSet hybrid(rendered, set.views, set.truth, {});
    return {hybrid.pixels().begin(), hybrid.pixels().end()};
}

}  // namespace probebake::study
