#include "render/render.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <stdexcept>

#include "render/adaptive.h"
#include "render/error_aware.h"
#include "render/hybrid_view.h"
#include "render/tiles.h"

namespace probebake {
namespace {

class ViewRenderer {
  public:
    ViewRenderer(const RenderScene& scene, const View& view, const RenderSettings& settings,
                 const CancelToken& cancel, const ViewExtent& extent)
        : scene_(scene), view_(view), settings_(settings), cancel_(cancel), extent_(extent) {
        const auto pixels =
            static_cast<size_t>(view.width_px) * static_cast<size_t>(view.height_px);
        out_.color = Image(view.width_px, view.height_px);
        out_.aux.resize(pixels);
    }

    ViewRender run() {
        for (int y = 0; y < view_.height_px; ++y) {
            for (int x = 0; x < view_.width_px; ++x) out_.pixels += renders(x, y) ? 1 : 0;
        }
        switch (settings_.kind) {
            case RendererKind::kReference:
                reference();
                break;
            case RendererKind::kLod:
                each_pixel([&](int x, int y, CostStats& stats) {
                    return lod_pixel(scene_, view_, x, y, settings_, stats);
                });
                break;
            case RendererKind::kErrorAware:
                if (extent_.ray_limit) {
                    error_aware_within(*extent_.ray_limit);
                } else {
                    each_pixel([&](int x, int y, CostStats& stats) {
                        return error_aware_pixel(scene_, view_, x, y, settings_, stats);
                    });
                }
                break;
            case RendererKind::kAdaptive:
                adaptive();
                break;
            case RendererKind::kHybrid:
                return render_hybrid_view(scene_, view_, settings_, cancel_, extent_);
            case RendererKind::kPaths:
                throw std::invalid_argument("a view is not rendered by paths");
        }
        return std::move(out_);
    }

  private:
    /// A pixel whose first ray asks for refinement.
    struct Refinable {
        int x;
        int y;
        FirstRay first;
    };

    bool renders(int x, int y) const { return renders_pixel(extent_.face, x, y, view_.width_px); }
    void store(int x, int y, const PixelSums& sums) { out_.store(x, y, sums); }

    template <class RenderPixel>
    void each_pixel(RenderPixel render_pixel) {
        out_.stats = for_each_row(view_.height_px, cancel_, [&](int y, CostStats& stats) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (renders(x, y)) store(x, y, render_pixel(x, y, stats));
            }
        });
    }

    void reference() {
        int grid = settings_.leaf_grid;
        const auto cost = [&] { return static_cast<uint64_t>(grid * grid) * out_.pixels; };
        while (extent_.ray_limit && grid > 1 && cost() > *extent_.ray_limit) --grid;
        out_.limited = grid < settings_.leaf_grid;
        each_pixel([&](int x, int y, CostStats& stats) {
            const Vec2 shift = settings_.shifted_grid ? grid_shift(x, y) : Vec2(0.0);
            return uniform_pixel(scene_, view_, x, y, {grid, shift}, stats);
        });
    }

    /// First rays everywhere; then refinement in rounds, the largest errors first. A round takes as
    /// many pixels as the rays that are left can pay for at worst, so that the limit always holds.
    void error_aware_within(uint64_t ray_limit) {
        std::vector<std::vector<Refinable>> rows(static_cast<size_t>(view_.height_px));
        out_.stats = for_each_row(view_.height_px, cancel_, [&](int y, CostStats& stats) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!renders(x, y)) continue;
                const FirstRay first = first_ray(scene_, view_, x, y, settings_);
                PixelSums sums;
                sums.add(scene_, first.color, first.hit.t, 1.0);
                store(x, y, sums);
                if (needs_refinement(first.error, settings_.threshold)) {
                    rows[static_cast<size_t>(y)].push_back({x, y, first});
                } else {
                    stats.keep(first.hit);
                }
            }
        });
        std::vector<Refinable> waiting;
        for (const auto& row : rows) waiting.insert(waiting.end(), row.begin(), row.end());
        std::stable_sort(
            waiting.begin(), waiting.end(),
            [](const Refinable& a, const Refinable& b) { return a.first.error > b.first.error; });

        uint64_t worst = 4;  // the quadrants' rays, then the leaf grids
        for (const int grid : kLeafGrids) {
            const bool possible = grid == 4 || std::isfinite(settings_.spread);
            if (possible && grid <= settings_.leaf_grid)
                worst += static_cast<uint64_t>(grid * grid);
        }
        size_t refined = 0;
        for (;;) {
            // The first rays of waiting pixels are cast, but not yet counted.
            const uint64_t spent = out_.stats.all_rays() + (waiting.size() - refined);
            const uint64_t affordable = ray_limit > spent ? (ray_limit - spent) / worst : 0;
            const size_t round = std::min<size_t>(affordable, waiting.size() - refined);
            if (round == 0) break;
            out_.stats += refine(std::span<const Refinable>(waiting).subspan(refined, round));
            refined += round;
        }
        out_.limited = refined < waiting.size();
        for (; refined < waiting.size(); ++refined) out_.stats.keep(waiting[refined].first.hit);
    }

    CostStats refine(std::span<const Refinable> pixels) {
        return for_each_row(static_cast<int>(pixels.size()), cancel_, [&](int i, CostStats& stats) {
            const Refinable& pixel = pixels[static_cast<size_t>(i)];
            stats.discard(pixel.first.hit);
            store(pixel.x, pixel.y,
                  refine_pixel(scene_, view_, pixel.x, pixel.y, settings_, stats));
        });
    }

    void adaptive() {
        std::vector<OneRayPixel> first(out_.aux.size());
        std::vector<CostStats> first_stats(out_.aux.size());
        const CostStats first_pass = for_each_row(view_.height_px, cancel_, [&](int y, CostStats&) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!renders(x, y)) continue;
                CostStats& stats = first_stats[view_.index(x, y)];
                const PixelSums sums = lod_pixel(scene_, view_, x, y, settings_, stats);
                store(x, y, sums);
                first[view_.index(x, y)] = {luminance(sums.mean()), true, stats.missed_rays == 0};
            }
        });
        std::vector<double> variation(first.size());
        std::vector<double> rendered;
        for (int y = 0; y < view_.height_px; ++y) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!renders(x, y)) continue;
                variation[view_.index(x, y)] = luminance_variation(
                    first, view_.width_px, view_.height_px, x, y, settings_.misses_in_kernel);
                rendered.push_back(variation[view_.index(x, y)]);
            }
        }
        double normaliser = settings_.normaliser;
        if (extent_.ray_limit && adaptive_rays(rendered, normaliser) > *extent_.ray_limit) {
            normaliser = solve_normaliser(std::move(rendered), *extent_.ray_limit);
            out_.limited = true;
        }
        out_.stats = for_each_row(view_.height_px, cancel_, [&](int y, CostStats& stats) {
            for (int x = 0; x < view_.width_px; ++x) {
                if (!renders(x, y)) continue;
                const CostStats& cast = first_stats[view_.index(x, y)];
                const int grid = adaptive_grid(variation[view_.index(x, y)], normaliser);
                if (grid == 0) {
                    stats += cast;
                    continue;
                }
                ++stats.discarded_rays;
                stats.steps += cast.steps;
                store(x, y, uniform_pixel(scene_, view_, x, y, grid, stats));
            }
        });
        out_.stats.seconds += first_pass.seconds;
    }

    const RenderScene& scene_;
    const View& view_;
    const RenderSettings& settings_;
    const CancelToken& cancel_;
    ViewExtent extent_;
    ViewRender out_;
};

}  // namespace

const char* name_of(RendererKind kind) {
    switch (kind) {
        case RendererKind::kReference:
            return "reference";
        case RendererKind::kLod:
            return "lod";
        case RendererKind::kAdaptive:
            return "adaptive";
        case RendererKind::kErrorAware:
            return "error_aware";
        case RendererKind::kHybrid:
            return "hybrid";
        case RendererKind::kPaths:
            return "paths";
    }
    return "";
}

void ViewRender::store(int x, int y, const PixelSums& sums) {
    color.at(x, y) = sums.mean();
    const auto index =
        static_cast<size_t>(y) * static_cast<size_t>(color.width()) + static_cast<size_t>(x);
    aux[index] = {static_cast<float>(sums.distance), static_cast<float>(sums.squared_distance),
                  sums.standard_error(), static_cast<float>(sums.samples)};
    aux[index].near_distance = static_cast<float>(sums.near_distance);
    aux[index].squared_near_distance = static_cast<float>(sums.squared_near_distance);
}

ViewRender render_view(const RenderScene& scene, const View& view, const RenderSettings& settings,
                       const CancelToken& cancel, const ViewExtent& extent) {
    return ViewRenderer(scene, view, settings, cancel, extent).run();
}

CostStats CubemapRender::total() const {
    CostStats sum;
    for (const CostStats& face : faces) sum += face;
    return sum;
}

CubemapRender render_cubemap(const RenderScene& scene, const Vec3& origin, int n,
                             const RenderSettings& settings, const CancelToken& cancel,
                             std::optional<uint64_t> ray_limit) {
    std::array<ViewExtent, kFaceCount> extents;
    uint64_t pixels_before = 0;
    for (const CubeFace face : kCubeFaces) {
        ViewExtent& extent = extents[static_cast<size_t>(index_of(face))];
        extent.face = face;
        const uint64_t pixels_after = pixels_before + owned_pixel_count(face, n);
        if (ray_limit) {
            const auto share = [&](uint64_t pixels) {
                return static_cast<uint64_t>(static_cast<unsigned __int128>(*ray_limit) * pixels /
                                             owned_pixel_count(n));
            };
            extent.ray_limit = share(pixels_after) - share(pixels_before);
        }
        pixels_before = pixels_after;
    }
    std::array<ViewRender, kFaceCount> views;
    tbb::parallel_for(0, kFaceCount, [&](int f) {
        const CubeFace face = kCubeFaces[static_cast<size_t>(f)];
        views[static_cast<size_t>(f)] =
            render_view(scene, cube_face_view(face, n, origin), settings, cancel,
                        extents[static_cast<size_t>(f)]);
    });
    return join_faces(n, views);
}

CubemapRender join_faces(int n, const std::array<ViewRender, kFaceCount>& views) {
    CubemapRender out{.color = Cubemap(n)};
    for (const CubeFace face : kCubeFaces) {
        const auto f = static_cast<size_t>(index_of(face));
        const ViewRender& view = views[f];
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) out.color.at({face, x, y}) = view.color.at(x, y);
        }
        out.aux.insert(out.aux.end(), view.aux.begin(), view.aux.end());
        out.faces[f] = view.stats;
        out.pixels[f] = view.pixels;
        out.limited = out.limited || view.limited;
    }
    out.color.share_edges();
    for_each_shared_pixel(n, [&](const CubePixel& pixel, const CubePixel& owner) {
        out.aux[cube_index(pixel, n)] = out.aux[cube_index(owner, n)];
    });
    return out;
}

}  // namespace probebake
