#include "volume_study/tracker_tables.h"

#include "math/estimate.h"
#include "scatter/path_tracer.h"
#include "track/decomposition.h"
#include "track/delta.h"
#include "track/media_line.h"
#include "track/residual_flight.h"
#include "track/spectral.h"
#include "track/spectral_mis.h"
#include "volume_study/cpu_clock.h"
#include "volume_study/line_plot.h"
#include "volume_study/test_media.h"

namespace probebake::volume_study {
namespace {

using study::decimals;

struct Measured {
    std::array<Moments, 3> radiance;
    PathCount count;
    double seconds = 0.0;

    double variance() const {
        return (radiance[0].variance() + radiance[1].variance() + radiance[2].variance()) / 3.0;
    }
    /// Look-ups and leaf steps alike, as counted costs are.
    double cost() const {
        return static_cast<double>(count.lookups() + count.flights.leaves + count.shadows.leaves);
    }
};

Measured measure(const Cloud& cloud, const PathTracer& tracer, int samples) {
    Measured out;
    const double start = cpu_seconds();
    for (int i = 0; i < samples; ++i) {
        RandomStream for_ray(random_key({21, static_cast<uint64_t>(i)}));
        PathRandom random(random_key({22, static_cast<uint64_t>(i)}));
        const PathResult path = tracer.trace(ray_at_cloud(cloud, for_ray), {}, random, out.count);
        for (int c = 0; c < 3; ++c) {
            out.radiance[static_cast<size_t>(c)].add(path.radiance[c]);
        }
    }
    out.seconds = cpu_seconds() - start;
    return out;
}

study::TextTable efficiency_table(const Cloud& cloud, const TestMedium& medium, int samples) {
    study::TextTable table;
    table.name = std::string("efficiency_") + medium.name;
    table.title = std::string(medium.title) + ", thickest column " + decimals(medium.column, 0) +
                  ", " + std::to_string(samples) + " paths";
    table.columns = {"tracker",         "mean R",      "mean G",
                     "mean B",          "variance",    "lookups per path",
                     "leaves per path", "µs per path", "efficiency by counts",
                     "by time",         "faults"};
    const Media media = media_of(cloud, medium);
    const VoxelTree no_voxels;
    const Lighting lighting = test_sky();
    const ScatterScene scene{no_voxels, 1.0, Vec3(0.0), media, lighting};
    const MediaFacts facts = facts_of(media);
    std::optional<Measured> base;
    for (int k = static_cast<int>(TrackerKind::kDelta); k < kTrackerKinds; ++k) {
        ChoiceParams params;
        params.forced = static_cast<TrackerKind>(k);
        TrackerChoice choice = choose_tracker(facts, params);
        // The base: three per-channel delta flights, also where the medium is gray.
        if (!base) {
            TrackerChoice apart = choice;
            apart.gray = false;
            base = measure(cloud, PathTracer(scene, apart), samples);
        }
        const Measured got = measure(cloud, PathTracer(scene, choice), samples);
        const double n = samples;
        table.rows.push_back(
            {name_of(choice.tracker), decimals(got.radiance[0].mean(), 4),
             decimals(got.radiance[1].mean(), 4), decimals(got.radiance[2].mean(), 4),
             decimals(got.variance(), 4), decimals(static_cast<double>(got.count.lookups()) / n, 1),
             decimals(static_cast<double>(got.count.flights.leaves) / n, 1),
             decimals(1e6 * got.seconds / n, 1),
             decimals(base->variance() * base->cost() / (got.variance() * got.cost()), 2),
             decimals(base->variance() * base->seconds / (got.variance() * got.seconds), 2),
             std::to_string(got.count.all_faults())});
    }
    return table;
}

/// First flights of a tracker along fixed rays.
template <int N, class Fly>
void first_flights(const Media& media, const Cloud& cloud, int samples, Fly fly) {
    for (int i = 0; i < samples; ++i) {
        RandomStream random(random_key({31, static_cast<uint64_t>(i)}));
        const Ray ray = ray_at_cloud(cloud, random);
        MediaLine<N> line(media, ray, {});
        fly(line, random);
    }
}

}  // namespace

std::vector<study::TextTable> efficiency_tables(
    const Cloud& cloud, int samples, const std::function<void(const std::string&)>& progress) {
    std::vector<study::TextTable> tables;
    for (const TestMedium& medium : test_media()) {
        progress(std::string("efficiency: ") + medium.name);
        tables.push_back(efficiency_table(cloud, medium, samples));
    }
    return tables;
}

study::TextTable control_table(const Cloud& cloud, int samples, const std::filesystem::path& out) {
    study::TextTable table;
    table.name = "control";
    table.title = cloud.name +
                  ", column 10: weighted decomposition to the first real collision, "
                  "control from 0 to the majorant (figures 1 to 3)";
    table.columns = {"depth",  "control / majorant", "lookups (N_dcmp)", "ρ = N_dcmp / N_delta",
                     "mean w", "variance of w",      "ρ · variance"};
    LinePlot plot{.name = "control",
                  .title = cloud.name + ", column 10: weighted decomposition",
                  .x_label = "control / majorant",
                  .y_label = "",
                  .log_axes = "y",
                  .lines = {}};
    for (const int depth : {1, 5}) {
        const std::string at = ", depth " + std::to_string(depth);
        for (const char* what : {"lookups / delta", "variance of w", "product"}) {
            plot.lines.push_back({what + at, {}});
        }
        const Media media({cloud_medium(cloud, 10.0, Rgb(0.0f), Rgb(1.0f), 0.0)},
                          {.max_depth = depth, .threshold = 0.2});
        TrackCount delta;
        first_flights<1>(media, cloud, samples, [&](MediaLine<1>& line, RandomStream& random) {
            Spectrum<1> w(1.0);
            DeltaTracker::fly<TrackTraits<1, false, false>>(line, w, random, delta,
                                                            CollectNothing());
        });
        for (int step = -1; step <= 8; ++step) {
            const ControlSetting control{step < 0 ? -1.0 : step / 8.0};
            TrackCount count;
            Moments weight;
            first_flights<1>(media, cloud, samples, [&](MediaLine<1>& line, RandomStream& random) {
                Spectrum<1> w(1.0);
                WeightedDecomposition::fly<TrackTraits<1, false, false>>(line, w, random, count,
                                                                         CollectNothing(), control);
                weight.add(w[0]);
            });
            const double rho =
                static_cast<double>(count.lookups) / static_cast<double>(delta.lookups);
            table.rows.push_back(
                {std::to_string(depth), step < 0 ? "minorant" : decimals(step / 8.0, 3),
                 decimals(static_cast<double>(count.lookups) / samples, 3), decimals(rho, 3),
                 decimals(weight.mean(), 3), decimals(weight.variance(), 3),
                 decimals(rho * weight.variance(), 3)});
            if (step < 0) continue;
            const std::array<double, 3> y = {rho, weight.variance(), rho * weight.variance()};
            for (size_t k = 0; k < 3; ++k) {
                if (y[k] > 0.0)
                    plot.lines[plot.lines.size() - 3 + k].points.push_back({step / 8.0, y[k]});
            }
        }
    }
    write_plot(out, plot);
    return table;
}

study::TextTable first_flight_table(const Cloud& cloud, int samples) {
    study::TextTable table;
    table.name = "figure_4";
    table.title = cloud.name +
                  ", absorption .2:.3:.6, scattering 1.1:1.2:1.0, column 10: flights "
                  "to the first real collision or the exit (figure 4)";
    table.columns = {"tracker",    "lookups",    "largest throughput",
                     "variance R", "variance G", "variance B"};
    const Media media(
        {cloud_medium(cloud, 10.0, Rgb(0.2f, 0.3f, 0.6f), Rgb(1.1f, 1.2f, 1.0f), 0.0)},
        {.max_depth = 4, .threshold = 0.2});
    using Traits = TrackTraits<3, true, false>;
    const auto add = [&](const char* name, auto fly) {
        TrackCount count;
        std::array<Moments, 3> weights;
        double largest = 0.0;
        first_flights<3>(media, cloud, samples, [&](MediaLine<3>& line, RandomStream& random) {
            Spectrum<3> w(1.0);
            const FlightEnd end = fly(line, w, random, count);
            if (end.event == Event::kAbsorb) w = Spectrum<3>();
            largest = std::max(largest, w.max());
            for (int c = 0; c < 3; ++c) weights[static_cast<size_t>(c)].add(w[c]);
        });
        table.rows.push_back({name, decimals(static_cast<double>(count.lookups) / samples, 3),
                              decimals(largest, 3), decimals(weights[0].variance(), 3),
                              decimals(weights[1].variance(), 3),
                              decimals(weights[2].variance(), 3)});
    };
    add("naive delta, a channel at a time",
        [](MediaLine<3>& line, Spectrum<3>& w, RandomStream& random, TrackCount& count) {
            const int channel = static_cast<int>(random.below(3));
            ChannelLine<MediaLine<3>> one(line, channel);
            Spectrum<1> own(3.0);
            const FlightEnd end = DeltaTracker::fly<TrackTraits<1, true, false>>(
                one, own, random, count, CollectNothing());
            w = Spectrum<3>();
            w[channel] = own[0];
            return end;
        });
    const auto add_spectral = [&](const char* name, auto tracker) {
        add(name, [&](MediaLine<3>& line, Spectrum<3>& w, RandomStream& random, TrackCount& count) {
            return decltype(tracker)::template fly<Traits>(line, w, random, count,
                                                           CollectNothing());
        });
    };
    add_spectral("free-path-sampling residual ratio", ResidualRatioFlight());
    add_spectral("spectral, average", SpectralTracker<Scheme::kAverage>());
    add_spectral("spectral, maximum", SpectralTracker<Scheme::kMax, Termination::kGap>());
    add_spectral("spectral, maximum, decomposition",
                 SpectralTracker<Scheme::kMax, Termination::kGap, true>());
    add_spectral("history-aware average", SpectralTracker<Scheme::kHistoryAverage>());
    add_spectral("spectral MIS", SpectralMis());
    return table;
}

}  // namespace probebake::volume_study
