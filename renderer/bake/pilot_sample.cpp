#include "bake/pilot_sample.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "image/exposure.h"
#include "image/metrics.h"
#include "image/ssim.h"
#include "render/adaptive.h"

namespace probebake {
namespace {

constexpr uint64_t kMaxProbes = 64;
constexpr uint64_t kMinPixels = 384;
constexpr uint64_t kMaxPixels = 4096;
constexpr uint64_t kTexelsPerPixel = 200;
/// Where pixels only show exposure and curve.
constexpr uint64_t kTexelsPerLeafPixel = 800;
constexpr uint64_t kMinWindows = 12;
constexpr uint64_t kMaxWindows = 48;
/// Largest standard error that the truth's noise may give the mean squared error, as a share of
/// what the target allows.
constexpr double kTruthNoiseShare = 0.25;

}  // namespace

uint64_t pilot_pixels(const JobSpec& job) {
    const uint64_t texels = texel_count(job) / job.states.size();
    const uint64_t per_pixel = wants_leaf_rays_only(job) ? kTexelsPerLeafPixel : kTexelsPerPixel;
    return std::min(texels, std::clamp(texels / per_pixel, kMinPixels, kMaxPixels));
}

PilotSample::PilotSample(const Scene& scene, const JobSpec& job, ReadyState state,
                         const CancelToken& cancel)
    : scene_(scene), job_(job), state_(std::move(state)), cancel_(cancel) {
    sample_.rel_mse = has_target(job.quality, QualityTarget::Metric::kRelMse);
    choose_places();
    const QualityTarget& target = job.quality.targets.front();
    const bool of_error = target.metric == QualityTarget::Metric::kPsnrDb ||
                          target.metric == QualityTarget::Metric::kRmse;
    if (wants_leaf_rays_only(job)) {  // nothing is searched
        truth_grid_ = irradiance_truth_grid(1);
        if (!job.quality.exposure) cast_truth();
        set_exposure();
        return;
    }
    for (const int grid : kTruthGrids) {
        truth_grid_ = grid;
        cast_truth();
        set_exposure();
        if (!of_error || job.quality.against == Against::kReference) break;
        if (truth_noise() <= kTruthNoiseShare * largest_square(target)) break;
    }
}

void PilotSample::choose_places() {
    RandomStream random(random_key(
        {job_.seed, static_cast<uint64_t>(StreamPurpose::kPilotChoice), stream_of(state_.spec)}));
    std::vector<size_t> probes(job_.probes.size());
    std::iota(probes.begin(), probes.end(), size_t{0});
    const size_t used = std::min<size_t>(probes.size(), kMaxProbes);
    for (size_t i = 0; i < used; ++i) {
        std::swap(probes[i], probes[i + random.below(probes.size() - i)]);
    }
    const uint64_t pixels = pilot_pixels(job_);
    sample_.windows = has_target(job_.quality, QualityTarget::Metric::kSsim);
    uint64_t squares = pixels;
    if (sample_.windows) {
        squares = std::clamp(pixels / kSsimWindow_px / kSsimWindow_px, kMinWindows, kMaxWindows);
    }
    for (uint64_t i = 0; i < squares; ++i) {
        add_square(probes[i % used], random, sample_.windows ? kSsimWindow_px : 1);
    }
}

/// Adds side × side pixels that lie anywhere in a face with the same probability.
void PilotSample::add_square(size_t probe, RandomStream& random, int side) {
    const int n = job_.probes[probe].face_size_px;
    const CubeFace face = kCubeFaces[random.below(kFaceCount)];
    const auto range = static_cast<uint64_t>(n - side + 1);
    const int left = static_cast<int>(random.below(range));
    const int top = static_cast<int>(random.below(range));
    for (int y = top; y < top + side; ++y) {
        for (int x = left; x < left + side; ++x) {
            places_.push_back({probe, {face, x, y}});
            SearchPixel pixel;
            pixel.weight = pixel_weight(job_.quality.weighting, {face, x, y}, n);
            sample_.pixels.push_back(pixel);
        }
    }
}

/// Calls cast(target, stats) for every pixel in parallel; returns the costs, added up in order.
template <class Cast>
CostStats PilotSample::for_each_pixel(Cast cast) const {
    std::vector<CostStats> stats(places_.size());
    tbb::parallel_for(size_t{0}, places_.size(), [&](size_t i) {
        if (cancel_.cancelled()) return;
        const auto start = std::chrono::steady_clock::now();
        const ProbeSpec& probe = job_.probes[places_[i].probe];
        const CubePixel owner = owner_of(places_[i].pixel, probe.face_size_px);
        const RenderScene scene = render_scene(scene_, probe, state_);
        const View view = face_view(scene_, probe, owner.face);
        cast(Target{i, scene, view, owner}, stats[i]);
        stats[i].seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    });
    cancel_.throw_if_cancelled();
    CostStats total;
    for (const CostStats& part : stats) total += part;
    return total;
}

void PilotSample::cast_truth() {
    search_cost_ += for_each_pixel([&](const Target& at, CostStats& stats) {
        // The index tells apart two draws of the same pixel.
        const uint64_t key =
            random_key({job_.seed, static_cast<uint64_t>(StreamPurpose::kPilotTruth),
                        stream_of(state_.spec), static_cast<uint64_t>(truth_grid_), at.index});
        sample_.pixels[at.index].truth =
            truth_pair(at.scene, at.view, at.owner.x, at.owner.y,
                       {.against = job_.quality.against, .grid = truth_grid_, .key = key}, stats);
    });
}

/// Standard error of the mean of (a − r1)(a − r2) for a perfect a: with s² the variance of r1, a
/// pixel contributes s⁴, and (r1 − r2)² is 2 s² on average.
double PilotSample::truth_noise() const {
    double sum = 0.0;
    for (const SearchPixel& pixel : sample_.pixels) {
        const Vec3 difference = (Vec3(pixel.truth.r1) - Vec3(pixel.truth.r2)) / sample_.exposure;
        const double variance = pixel.weight * glm::dot(difference, difference) / 6.0;
        sum += variance * variance;
    }
    return std::sqrt(sum) / static_cast<double>(sample_.pixels.size());
}

void PilotSample::set_exposure() {
    if (job_.quality.exposure) {
        sample_.exposure = *job_.quality.exposure;
        return;
    }
    std::vector<Rgb> colors;
    for (const SearchPixel& pixel : sample_.pixels) {
        colors.push_back((pixel.truth.r1 + pixel.truth.r2) * 0.5f);
    }
    sample_.exposure = exposure_of(colors);
}

void PilotSample::extend(const std::vector<RendererKind>& renderers, int leaf_grid) {
    const bool first_time = leaf_grid == kLeafGrids.front();
    const RendererKind kind = renderers.front();
    search_cost_ += for_each_pixel([&](const Target& at, CostStats& stats) {
        SearchPixel& pixel = sample_.pixels[at.index];
        const auto record = [&](int grid) {
            record_leaves(at.scene, at.view, at.owner.x, at.owner.y, grid, pixel.record, stats);
        };
        if (first_time) {
            pixel.record = record_refinement(at.scene, at.view, at.owner.x, at.owner.y, {}, stats);
        }
        if (kind == RendererKind::kLod) return;
        record(leaf_grid);
        if (first_time && renderers.size() > 1) {
            for (const int grid : kCoarseGrids) record(grid);
        }
        if (kind != RendererKind::kAdaptive) return;
        record(2);
        pixel.variation = variation_at(at, stats);
    });
}

void PilotSample::extend_hybrid(double price) {
    recorded_price_ = price;
    search_cost_ += for_each_pixel([&](const Target& at, CostStats& stats) {
        HybridRecord& record = sample_.pixels[at.index].hybrid;
        const HybridCast cast{at.scene, at.view, at.owner.x, at.owner.y};
        if (record.recorded() == 0) {
            record.pixel.evidence.contrast = contrast_at(at, stats);
            record_timed_stage(cast, record, stats);
        }
        while (record.recorded() < kHybridStages && record.gain() > price) {
            record_timed_stage(cast, record, stats);
        }
    });
}

void PilotSample::record_timed_stage(const HybridCast& cast, HybridRecord& record,
                                     CostStats& stats) {
    const auto start = std::chrono::steady_clock::now();
    record_stage(cast, record, stats);
    const auto stage = static_cast<size_t>(record.pixel.stage);
    record.stages[stage].seconds =
        (stage > 0 ? record.stages[stage - 1].seconds : 0.0) +
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

CurvePoint PilotSample::replayed(const RenderSettings& settings) const {
    const Candidate at = evaluate(sample_, settings);
    const auto n = static_cast<double>(sample_.pixels.size());
    return {settings, static_cast<uint64_t>(std::llround(at.rays_per_pixel * n)),
            static_cast<uint64_t>(std::llround(at.steps_per_pixel * n)), at.seconds_per_pixel * n,
            at.error};
}

/// Calls visit(place in the block, pixel) for the pixels of the 3×3 block around a pixel that its
/// face owns.
template <class Visit>
void for_each_near(const CubePixel& middle, int n, Visit visit) {
    for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
            const CubePixel near{middle.face, middle.x + i, middle.y + j};
            const bool inside = near.x >= 0 && near.y >= 0 && near.x < n && near.y < n;
            if (inside && owner_of(near, n) == near) {
                visit(static_cast<size_t>(3 * (j + 1) + i + 1), near);
            }
        }
    }
}

/// The contrast that the hybrid renderer sees at a pixel.
double PilotSample::contrast_at(const Target& at, CostStats& stats) const {
    std::array<Neighbour, 9> block;
    for_each_near(at.owner, at.view.width_px, [&](size_t place, const CubePixel& near) {
        HybridPixel first;
        cast_stage({at.scene, at.view, near.x, near.y}, first);
        stats += first.cost;
        block[place] = {first.color(), true};
    });
    return neighbour_contrast(block);
}

/// The adaptive renderer's variation of one pixel, from the first rays of its neighbours.
double PilotSample::variation_at(const Target& at, CostStats& stats) const {
    std::array<OneRayPixel, 9> pixels{};
    for_each_near(at.owner, at.view.width_px, [&](size_t place, const CubePixel& near) {
        CostStats one;
        const Rgb color = lod_pixel(at.scene, at.view, near.x, near.y, {}, one).mean();
        pixels[place] = {luminance(color), true, one.missed_rays == 0};
        stats += one;
    });
    return luminance_variation(pixels, 3, 3, 1, 1, MissesInKernel::kLeftOut);
}

CurvePoint PilotSample::render(const RenderSettings& settings) {
    std::vector<Rgb> colors(places_.size());
    const CostStats cost = for_each_pixel([&](const Target& at, CostStats& stats) {
        const int x = at.owner.x;
        const int y = at.owner.y;
        const auto render_pixel = [&]() -> PixelSums {
            switch (settings.kind) {
                case RendererKind::kReference:
                    return uniform_pixel(at.scene, at.view, x, y, settings.leaf_grid, stats);
                case RendererKind::kLod:
                    return lod_pixel(at.scene, at.view, x, y, settings, stats);
                case RendererKind::kErrorAware:
                    return error_aware_pixel(at.scene, at.view, x, y, settings, stats);
                case RendererKind::kHybrid:
                    return hybrid_pixel({at.scene, at.view, x, y, settings.hybrid},
                                        sample_.pixels[at.index].hybrid.pixel.evidence.contrast,
                                        settings, stats);
                case RendererKind::kAdaptive:
                case RendererKind::kPaths:
                    break;
            }
            const int grid = adaptive_grid(sample_.pixels[at.index].variation, settings.normaliser);
            PixelSums sums = lod_pixel(at.scene, at.view, x, y, settings, stats);
            return grid == 0 ? sums : uniform_pixel(at.scene, at.view, x, y, grid, stats);
        };
        colors[at.index] = render_pixel().mean();
    });
    return {settings, cost.all_rays(), cost.steps, cost.seconds, measure(sample_, colors)};
}

/// The same pixel as uniform leaf rays show it whose shift is independent of theirs; or what it is
/// measured against, where that is given.
Rgb PilotSample::other_leaf_rays(const Target& at, int leaf_grid, CostStats& stats) const {
    if (job_.quality.against == Against::kReference) {
        return uniform_pixel(at.scene, at.view, at.owner.x, at.owner.y, 4, stats).mean();
    }
    RandomStream random(
        random_key({job_.seed, static_cast<uint64_t>(StreamPurpose::kPilotTruth),
                    stream_of(state_.spec), static_cast<uint64_t>(leaf_grid), at.index, 1}));
    const double shift_x = random.uniform() - 0.5;
    const RayGrid grid(leaf_grid, {shift_x, random.uniform() - 0.5});
    return uniform_pixel(at.scene, at.view, at.owner.x, at.owner.y, grid, stats).mean();
}

const IrradianceNorms& PilotSample::irradiance_norms(const std::vector<NoisyPixel>& sample) {
    if (norms_) return *norms_;
    const auto see = [&](const CoarsePixel& at, CostStats& stats) {
        cancel_.throw_if_cancelled();
        const RenderScene scene = render_scene(scene_, at.probe, state_);
        const View view = face_view(scene_, at.probe, at.pixel.face);
        return CoarseColor{uniform_pixel(scene, view, at.pixel.x, at.pixel.y, 1, stats).mean()};
    };
    norms_ = coarse_irradiance_norms(job_.probes, sample, see);
    search_cost_ += norms_->cost;
    return *norms_;
}

CurvePoint PilotSample::render_leaf_rays(const RenderSettings& settings) {
    std::vector<Rgb> colors(places_.size());
    std::vector<Rgb> others(places_.size());
    const int side = settings.leaf_grid;
    const CostStats cost = for_each_pixel([&](const Target& at, CostStats& stats) {
        const RayGrid grid(side, grid_shift(at.owner.x, at.owner.y));
        colors[at.index] =
            uniform_pixel(at.scene, at.view, at.owner.x, at.owner.y, grid, stats).mean();
    });
    search_cost_ += for_each_pixel([&](const Target& at, CostStats& stats) {
        others[at.index] = other_leaf_rays(at, side, stats);
    });
    // Both differ from the truth by as much, but for a reference, which counts as the truth.
    const double share = job_.quality.against == Against::kReference ? 1.0 : 0.5;
    Moments moments;
    std::vector<NoisyPixel> noise;
    for (size_t i = 0; i < places_.size(); ++i) {
        const auto& [probe, pixel] = places_[i];
        const Vec3 difference = Vec3(colors[i]) - Vec3(others[i]);
        const double variance = share * glm::dot(difference, difference);
        const double exposure2 = sample_.exposure * sample_.exposure;
        moments.add(sample_.pixels[i].weight * variance / (3.0 * exposure2));
        noise.push_back({probe, pixel, job_.probes[probe].face_size_px, variance});
    }
    CurvePoint point{settings, cost.all_rays(), cost.steps, cost.seconds, {}};
    point.error.mse = Estimate::of_mean(moments);
    point.error.irradiance_square = expected_irradiance_square(noise, irradiance_norms(noise));
    return point;
}

}  // namespace probebake
