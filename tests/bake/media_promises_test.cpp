// What bakes through media promise, against renders of many more paths.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "bake/forecast.h"
#include "bake/learn.h"
#include "bake/media_fixture.h"
#include "image/sh_projection.h"
#include "image/ssim.h"

namespace probebake {
namespace {

using test::day_request;
using test::kFace;

/// Of all windows of all faces, against two independent references.
double mean_ssim(const Cubemap& cube, const Cubemap& r1, const Cubemap& r2, double exposure) {
    const int n = cube.face_size();
    const auto planes = [&](const Cubemap& of) {
        const auto pixels = static_cast<size_t>(n) * static_cast<size_t>(n);
        std::vector<LuminancePlane> faces(kFaceCount, LuminancePlane{n, n, {}});
        for (size_t i = 0; i < kFaceCount * pixels; ++i) {
            faces[i / pixels].values.push_back(ssim_luminance(of.at(pixel_at(i, n)), exposure));
        }
        return faces;
    };
    const auto a = planes(cube);
    const auto b = planes(r1);
    const auto c = planes(r2);
    Moments windows;
    for (size_t face = 0; face < kFaceCount; ++face) {
        for (int y = 0; y <= n - kSsimWindow_px; ++y) {
            for (int x = 0; x <= n - kSsimWindow_px; ++x) {
                windows.add(ssim(ssim_window(a[face], x, y), ssim_window(b[face], x, y),
                                 ssim_window(c[face], x, y)));
            }
        }
    }
    return windows.mean();
}

class MediaPromises : public test::MediaBake {
  protected:
    /// As a job's probes are baked: the first of them teach the pilot.
    std::vector<ProbeResult> bake_all(const JobSpec& job, Pilot& pilot) const {
        std::vector<ProbeResult> results;
        for (size_t i = 0; i < job.probes.size(); ++i) {
            const bool teaches = i < probes_to_learn_from(job);
            if (i == probes_to_learn_from(job)) learn(pilot, job.quality, results);
            results.push_back(
                bake_probe(scene_, job, pilot, {.probe = i, .teaches = teaches}, cancel_));
        }
        return results;
    }
    /// Of paths that no bake traces.
    Cubemap truth_of(const JobSpec& job, size_t probe, const Pilot& pilot, int paths,
                     uint64_t key) const {
        return render_through_media(scene_, *pilot.media->tracer,
                                    volume_view(scene_, job.probes[probe], key),
                                    {.kind = RendererKind::kPaths, .samples = paths}, {}, cancel_)
            .color;
    }
};

/// A job of 48 probes, some of them within the cloud.
constexpr int kProbes = 48;
Json many_probes(Json request) {
    request["probes"]["list"].clear();
    for (int i = 0; i < kProbes; ++i) {
        const int row = i / 4 % 3;
        const int layer = i / 12;
        const Vec3 p(-7.0 + 2.3 * (i % 4), 7.0 + 1.9 * row, 4.0 + 2.9 * layer);
        request["probes"]["list"].push_back(
            {{"id", "p" + std::to_string(i)}, {"position_m", {p.x, p.y, p.z}}});
    }
    return request;
}

/// Against renders of a thousand paths in every pixel.
TEST_F(MediaPromises, OfIrradianceHold) {
    constexpr double kIrradiance = 0.05;
    Json request = many_probes(day_request({{"irradiance_rel", kIrradiance}}));
    request["products"] = {"cube", "sh"};
    const JobSpec job = read_job(request);
    Pilot pilot = this->pilot(job);
    const std::vector<ProbeResult> results = bake_all(job, pilot);
    int kept = 0;
    int covered = 0;
    int within = 0;
    double paths = 0.0;
    double audit = 0.0;
    double render = 0.0;
    for (const ProbeResult& result : results) {
        EXPECT_TRUE(result.target_met);
        const ShRgb truth = project_sh(truth_of(job, result.probe, pilot, 1024, 1234));
        ShRgb difference = project_sh(cube_of(result));
        Vec3 squares(0.0);
        for (size_t k = 0; k < truth.size(); ++k) {
            difference[k] -= truth[k];
            squares += difference[k] * difference[k];
        }
        const double error = irradiance_norm(difference) / irradiance_norm(truth);
        const Interval& interval = result.pooled.front()->interval;
        kept += error <= kIrradiance ? 1 : 0;
        covered += error * error >= interval.low && error * error <= interval.high ? 1 : 0;
        const auto& bytes = result.files[1].bytes;
        const auto* text = reinterpret_cast<const char*>(bytes.data());
        const Json file = Json::parse(text, text + bytes.size());
        const double bound = file["error"]["irradiance_off_by_at_most"][0];
        within += kShLargestIrradiance * std::sqrt(squares.r) <= bound ? 1 : 0;
        EXPECT_NEAR(file["error"]["irradiance_rel_interval"][1], std::sqrt(interval.high), 1e-9);
        paths += static_cast<double>(result.render_cost().rays) / kProbes /
                 static_cast<double>(owned_pixel_count(kFace));
        render += static_cast<double>(result.render_cost().steps);
        audit += static_cast<double>(result.certificate.cost.steps + result.decision_cost.steps);
    }
    std::printf("of %d: %d kept, %d covered, %d within the bound; %.1f paths, audits %.3f\n",
                kProbes, kept, covered, within, paths, audit / render);
    // With 95 % kept, fewer than 41 of 48 would be by chance in 0.5 % of all cases.
    EXPECT_GE(kept, 41);
    EXPECT_GE(covered, 41);
    EXPECT_GE(within, 41);
    EXPECT_LT(paths, 60.0);
}

/// Against two renders of 128 paths in every pixel, whose noise does not count.
TEST_F(MediaPromises, OfSsimHold) {
    constexpr double kSsim = 0.7;
    constexpr int kWindowFace = 14;
    Json request = many_probes(day_request({{"ssim", kSsim}}));
    request["face_size_px"] = kWindowFace;
    const JobSpec job = read_job(request);
    Pilot pilot = this->pilot(job);
    const std::vector<ProbeResult> results = bake_all(job, pilot);
    int kept = 0;
    int covered = 0;
    double paths = 0.0;
    double audit = 0.0;
    double render = 0.0;
    for (const ProbeResult& result : results) {
        EXPECT_TRUE(result.target_met);
        const double ssim =
            mean_ssim(cube_of(result), truth_of(job, result.probe, pilot, 128, 1234),
                      truth_of(job, result.probe, pilot, 128, 4321), pilot.exposure);
        const Interval& lost = result.pooled.front()->interval;
        kept += ssim >= kSsim ? 1 : 0;
        covered += 1.0 - ssim >= lost.low && 1.0 - ssim <= lost.high ? 1 : 0;
        paths += static_cast<double>(result.render_cost().rays) / kProbes /
                 static_cast<double>(owned_pixel_count(kWindowFace));
        render += static_cast<double>(result.render_cost().steps);
        audit += static_cast<double>(result.certificate.cost.steps + result.decision_cost.steps);
    }
    std::printf("of %d: %d kept, %d covered; %.1f paths, audits %.3f\n", kProbes, kept, covered,
                paths, audit / render);
    // With 95 % kept, fewer than 41 of 48 would be by chance in 0.5 % of all cases.
    EXPECT_GE(kept, 41);
    EXPECT_GE(covered, 41);
    EXPECT_LT(audit, 0.15 * render);
}

/// Its probes have faces of windows of SSIM, and learn from each other as the job's do.
TEST_F(MediaPromises, ForecastsOfSsimAreMadeWithWindows) {
    Json request = many_probes(day_request({{"ssim", 0.5}}));
    request["face_size_px"] = 16;
    const JobSpec job = read_job(request);
    const Plan plan = make_plan(scene_, job);
    const Forecast forecast = make_forecast(scene_, job, plan, 2, cancel_);
    EXPECT_GT(forecast.seconds, 0.0);
    Pilot pilot = this->pilot(job);
    double bytes = 0.0;
    for (const ProbeResult& result : bake_all(job, pilot)) {
        bytes += static_cast<double>(result.files.front().size_bytes);
    }
    EXPECT_NEAR(static_cast<double>(forecast.output_bytes) / bytes, 1.0, 0.25);
}

/// A check must not take as long as the bake: what it does not trace is told by what it leaves.
TEST_F(MediaPromises, ForecastsOfManyPathsTraceSome) {
    const auto seconds_of = [&](const Json& targets) {
        const JobSpec job = read_job(many_probes(day_request(targets)));
        const auto start = std::chrono::steady_clock::now();
        const Forecast forecast = make_forecast(scene_, job, make_plan(scene_, job), 2, cancel_);
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
        EXPECT_LT(took.count(), 120.0) << targets;
        return forecast;
    };
    const Forecast some = seconds_of({{"rmse", 0.03}});
    const Forecast many = seconds_of({{"rmse", 0.0003}});
    EXPECT_FALSE(some.extrapolated);
    EXPECT_TRUE(many.extrapolated);
    const double ratio = many.seconds / some.seconds;  // 10⁴ times the paths
    EXPECT_GT(ratio, 1e3);
    EXPECT_LT(ratio, 1e5);
    EXPECT_TRUE(seconds_of({{"rays", 1'000'000'000}}).extrapolated);
}

TEST_F(MediaPromises, CurveOfIrradianceTellsWhatCubemapsAreWrongBy) {
    const JobSpec job = read_job(day_request({{"irradiance_rel", 0.1}}));
    const Pilot pilot = this->pilot(job);
    ASSERT_EQ(pilot.curve.size(), 5u);
    const CurvePoint& point = pilot.curve[2];
    ASSERT_TRUE(point.error.irradiance_square);
    // Half the squared difference of two independent renders of the same probe.
    constexpr uint64_t kPairs = 8;
    Moments squares;
    for (const ProbeSpec& probe : job.probes) {
        for (uint64_t pair = 0; pair < kPairs; ++pair) {
            const auto sh = [&](uint64_t key) {
                return project_sh(render_through_media(scene_, *pilot.media->tracer,
                                                       volume_view(scene_, probe, key),
                                                       point.settings, {}, cancel_)
                                      .color);
            };
            const ShRgb one = sh(2 * pair + 1);
            ShRgb difference = sh(2 * pair + 2);
            for (size_t i = 0; i < one.size(); ++i) difference[i] -= one[i];
            const double relative = irradiance_norm(difference) / irradiance_norm(one);
            squares.add(relative * relative / 2.0);
        }
    }
    const Estimate found = Estimate::of_mean(squares);
    const Interval predicted = point.error.irradiance_square->interval(0.99);
    std::printf("%d paths: predicted %.5f, found %.5f\n", point.settings.samples,
                std::sqrt(point.error.irradiance_square->value), std::sqrt(found.value));
    EXPECT_LT(found.interval(0.99).low, predicted.high);
    EXPECT_GT(found.interval(0.99).high, predicted.low);
    EXPECT_LT(predicted.high, 4.0 * predicted.low);
}

}  // namespace
}  // namespace probebake
