#include <cmath>
#include <optional>

#include "scatter/path_tracer.h"
#include "volume_study/cloud_picture.h"
#include "volume_study/figures.h"
#include "volume_study/line_plot.h"
#include "volume_study/test_media.h"

namespace probebake::volume_study {
namespace {

using study::decimals;

constexpr std::array<int, 5> kSamples = {1, 4, 16, 64, 256};

PathFunction traced(const PathTracer& tracer) {
    return [&tracer](const Ray& ray, uint64_t key, PictureCost& cost) {
        PathRandom random(key);
        PathCount count;
        const PathResult path = tracer.trace(ray, {}, random, count);
        cost.counted += count.lookups() + count.flights.leaves + count.shadows.leaves;
        cost.faults += count.all_faults();
        return path.radiance;
    };
}

}  // namespace

study::TextTable curve_table(const Cloud& cloud, const FigureParams& params,
                             const std::function<void(const std::string&)>& progress) {
    study::TextTable table;
    table.name = "error_against_time";
    table.title = cloud.name + ", " + std::to_string(params.side) +
                  "² pixels: RMSE against CPU seconds and M lookups and leaves";
    table.columns = {"medium",    "tracker", "paths per pixel",     "CPU s",
                     "M counted", "RMSE",    "time to equal error", "faults"};
    const VoxelTree no_voxels;
    const Lighting lighting = test_sky();
    for (const TestMedium& medium : test_media()) {
        progress(std::string("curves: ") + medium.name);
        const Media media = media_of(cloud, medium);
        const ScatterScene scene{no_voxels, 1.0, Vec3(0.0), media, lighting};
        const auto picture = [&](const TrackerChoice& choice, int samples, uint64_t key) {
            const PathTracer tracer(scene, choice);
            return render_picture(cloud, {.side = params.side, .samples = samples, .key = key},
                                  traced(tracer));
        };
        const MediaFacts facts = facts_of(media);
        const auto forced = [&](TrackerKind kind) {
            ChoiceParams choice;
            choice.forced = kind;
            return choose_tracker(facts, choice);
        };
        // Two estimators of the truth whose weights are bounded.
        const CloudPicture r1 = picture(forced(TrackerKind::kHistoryAverage), params.reference, 81);
        const CloudPicture r2 = picture(forced(TrackerKind::kSpectralMis), params.reference, 82);
        LinePlot plot{.name = std::string("error_against_time_") + medium.name,
                      .title = medium.title,
                      .x_label = "CPU seconds",
                      .y_label = "RMSE",
                      .log_axes = "xy",
                      .lines = {}};
        std::optional<double> apart;  // error² × seconds of channels apart
        const auto add = [&](const std::string& name, const TrackerChoice& choice) {
            plot.lines.push_back({name, {}});
            for (const int samples : kSamples) {
                const CloudPicture got = picture(choice, samples, 83);
                const double mse = squared_error(got, r1, r2);
                const double price = mse * got.cost.seconds;
                if (!apart && samples == kSamples.back()) apart = price;
                table.rows.push_back({medium.name, name, std::to_string(samples),
                                      decimals(got.cost.seconds, 3),
                                      decimals(static_cast<double>(got.cost.counted) * 1e-6, 3),
                                      decimals(std::sqrt(std::max(0.0, mse)), 4),
                                      samples == kSamples.back() ? decimals(price / *apart, 2) : "",
                                      std::to_string(got.cost.faults)});
                if (mse > 0.0) {
                    plot.lines.back().points.push_back({got.cost.seconds, std::sqrt(mse)});
                }
            }
        };
        TrackerChoice apart_choice = forced(TrackerKind::kDelta);
        apart_choice.gray = false;
        add("channels apart, delta", apart_choice);
        for (int k = static_cast<int>(TrackerKind::kDelta); k < kTrackerKinds; ++k) {
            const auto kind = static_cast<TrackerKind>(k);
            if (kind == TrackerKind::kDelta && !facts.gray_extinction) continue;
            add(name_of(kind), forced(kind));
        }
        write_plot(params.out, plot);
    }
    return table;
}

}  // namespace probebake::volume_study
