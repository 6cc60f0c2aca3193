#include "volume_study/depth_tables.h"

#include "track/decomposition.h"
#include "track/delta.h"
#include "track/media_line.h"
#include "volume/phase.h"
#include "volume_study/cpu_clock.h"
#include "volume_study/line_plot.h"

namespace probebake::volume_study {
namespace {

using study::decimals;

constexpr std::array<int, 4> kDepths = {1, 4, 8, 16};

using PerDepth = std::array<double, 4>;  // at kDepths

/// Single-core seconds of the supplemental, of delta tracking and of decomposition.
struct PublishedTimes {
    std::array<PerDepth, 2> lookup;
    std::array<PerDepth, 2> octree;
    std::array<PerDepth, 2> tracker;
};

/// Counts of the supplemental in 10⁹, and times.
struct Published {
    PerDepth leaves;
    PerDepth delta;
    PerDepth decomposition;
    PublishedTimes seconds;
};
constexpr Published kThin = {{0.12, 0.31, 1.32, 2.02},
                             {0.74, 0.24, 0.080, 0.074},
                             {0.74, 0.23, 0.032, 0.022},
                             {{{{201, 88, 44, 43}, {201, 87, 26, 20}}},
                              {{{3.58, 40, 216, 365}, {3.58, 42, 253, 414}}},
                              {{{49, 30, 78, 115}, {49, 31, 98, 142}}}}};
constexpr Published kThick = {{1.86, 2.06, 3.11, 4.05},
                              {106, 22.8, 2.96, 2.49},
                              {106, 22.6, 1.71, 1.03},
                              {{{{20065, 5785, 1030, 876}, {20065, 5472, 536, 336}}},
                               {{{64, 315, 734, 916}, {64, 319, 714, 918}}},
                               {{{6108, 1389, 299, 321}, {6108, 1379, 280, 300}}}}};

/// A flight's line, kept for timing its parts.
struct Flown {
    Ray ray;
    double end = 0.0;
};

/// CPU seconds: of look-ups, of the walk through the octree, of what is left.
struct Times {
    double lookup = 0.0;
    double octree = 0.0;
    double tracker = 0.0;
};

struct Run {
    TrackCount count;
    Times seconds;
};

/// Paths of albedo 1 through the cloud until they leave it.
template <class Tracker>
Run run_paths(const Media& media, const Cloud& cloud, int paths) {
    Run run;
    std::vector<Flown> flown;
    constexpr size_t kKept = 100000;
    const double g = media.all().front().spec.g;
    const double start = cpu_seconds();
    for (int i = 0; i < paths; ++i) {
        RandomStream random(random_key({7, static_cast<uint64_t>(i)}));
        Ray ray = ray_at_cloud(cloud, random);
        for (;;) {
            MediaLine<1> line(media, ray, {});
            Spectrum<1> w(1.0);
            const FlightEnd end = Tracker::template fly<TrackTraits<1, false, false>>(
                line, w, random, run.count, CollectNothing());
            const bool out = end.event == Event::kEscape;
            if (flown.size() < kKept) {
                flown.push_back({ray, out ? std::numeric_limits<double>::infinity() : end.t});
            }
            if (out) break;
            ray.origin += ray.direction * end.t;
            const double cosine = sample_henyey_greenstein(g, random.uniform());
            ray.direction = around(ray.direction, cosine, random.uniform());
        }
    }
    const double all = cpu_seconds() - start;

    // The same leaves without a tracker, and look-ups along the same lines.
    uint64_t leaves = 0;
    uint64_t lookups = 0;
    double sum = 0.0;
    Segment<1> leaf;
    const auto walk = [&](auto visit) {
        const double from = cpu_seconds();
        for (const Flown& f : flown) {
            MediaLine<1> line(media, f.ray, {});
            while (line.next(leaf)) {
                visit(line, std::min(leaf.t1, f.end));
                if (leaf.t1 > f.end) break;
            }
        }
        return cpu_seconds() - from;
    };
    const double walking = walk([&](MediaLine<1>&, double) { ++leaves; });
    const double looking = walk([&](MediaLine<1>& line, double end) {
        for (int k = 0; k < 4; ++k) {
            sum += line.at(leaf.t0 + (k + 0.5) / 4.0 * (end - leaf.t0)).scattering[0];
            ++lookups;
        }
    });
    volatile double keep = sum;
    (void)keep;
    run.seconds.octree =
        walking / static_cast<double>(leaves) * static_cast<double>(run.count.leaves);
    run.seconds.lookup = std::max(0.0, looking - walking) / static_cast<double>(lookups) *
                         static_cast<double>(run.count.lookups);
    run.seconds.tracker = std::max(0.0, all - run.seconds.octree - run.seconds.lookup);
    return run;
}

std::string millions(uint64_t x) { return decimals(static_cast<double>(x) * 1e-6, 3); }

double ratio(uint64_t a, uint64_t b) { return static_cast<double>(a) / static_cast<double>(b); }

struct AtDepth {
    Run delta;
    Run decomposition;
};

/// Every time beside the published one, both over their own value at depth 1.
study::TextTable times_table(const study::TextTable& counts, const Published& published,
                             const std::vector<AtDepth>& runs) {
    study::TextTable table;
    table.name = counts.name + "_times";
    table.title = counts.title + ": CPU ms, and over those of depth 1";
    table.columns = {"depth",     "tracker",      "lookup ms",    "over depth 1", "Kutz",
                     "octree ms", "over depth 1", "Kutz",         "tracker ms",   "over depth 1",
                     "Kutz",      "all ms",       "over depth 1", "Kutz"};
    for (size_t i = 0; i < runs.size(); ++i) {
        for (const size_t kind : {size_t{0}, size_t{1}}) {
            const auto times = [&](size_t depth) {
                return (kind == 0 ? runs[depth].delta : runs[depth].decomposition).seconds;
            };
            const PublishedTimes& theirs = published.seconds;
            std::vector<std::string> row = {std::to_string(kDepths[i]),
                                            kind == 0 ? "delta" : "decomposition"};
            const auto add = [&](double now, double first, double their_now, double their_first) {
                row.push_back(decimals(1e3 * now, 2));
                row.push_back(first > 0.0 ? decimals(now / first, 2) : "–");
                row.push_back(decimals(their_now / their_first, 2));
            };
            const Times now = times(i);
            const Times first = times(0);
            add(now.lookup, first.lookup, theirs.lookup[kind][i], theirs.lookup[kind][0]);
            add(now.octree, first.octree, theirs.octree[kind][i], theirs.octree[kind][0]);
            add(now.tracker, first.tracker, theirs.tracker[kind][i], theirs.tracker[kind][0]);
            const auto their_sum = [&](size_t depth) {
                return theirs.lookup[kind][depth] + theirs.octree[kind][depth] +
                       theirs.tracker[kind][depth];
            };
            add(now.lookup + now.octree + now.tracker, first.lookup + first.octree + first.tracker,
                their_sum(i), their_sum(0));
            table.rows.push_back(std::move(row));
        }
    }
    return table;
}

/// Look-ups and leaves visited against the depth, ours and the published, over those of depth 1.
void plot_depths(const std::filesystem::path& out, const study::TextTable& counts,
                 const Published& published, const std::vector<AtDepth>& runs) {
    LinePlot plot{.name = counts.name,
                  .title = counts.title,
                  .x_label = "depth",
                  .y_label = "over delta tracking at depth 1",
                  .log_axes = "y",
                  .lines = {}};
    const auto add = [&](const std::string& name, auto ours, const PerDepth& theirs, double base) {
        PlotLine line{name, {}};
        PlotLine kutz{name + ", Kutz", {}};
        for (size_t i = 0; i < runs.size(); ++i) {
            const double depth = kDepths[i];
            line.points.push_back({depth, ours(runs[i])});
            kutz.points.push_back({depth, theirs[i] / base});
        }
        plot.lines.push_back(std::move(line));
        plot.lines.push_back(std::move(kutz));
    };
    const TrackCount& first = runs.front().delta.count;
    add(
        "lookups, delta",
        [&](const AtDepth& at) { return ratio(at.delta.count.lookups, first.lookups); },
        published.delta, published.delta[0]);
    add(
        "lookups, decomposition",
        [&](const AtDepth& at) { return ratio(at.decomposition.count.lookups, first.lookups); },
        published.decomposition, published.delta[0]);
    add(
        "leaves visited",
        [&](const AtDepth& at) { return ratio(at.delta.count.leaves, first.leaves); },
        published.leaves, published.leaves[0]);
    write_plot(out, plot);
}

/// Counts, then times.
std::array<study::TextTable, 2> depth_table(const Cloud& cloud, bool thick, int paths,
                                            const VolumeStudyParams& params) {
    study::TextTable table;
    table.name = cloud.name + (thick ? "_thick" : "_thin") + "_depth";
    table.title = cloud.name + (thick ? ", thick (column 500)" : ", thin (column 3)") + ", " +
                  std::to_string(paths) + " paths";
    table.columns = {"depth",
                     "reached",
                     "octree leaves",
                     "octree MB",
                     "leaves visited, M",
                     "lookups delta, M",
                     "lookups decomposition, M",
                     "ratio",
                     "Kutz",
                     "leaves against depth 1",
                     "Kutz",
                     "delta lookups against depth 1",
                     "Kutz"};
    const Published& published = thick ? kThick : kThin;
    std::vector<AtDepth> runs;
    for (size_t i = 0; i < kDepths.size(); ++i) {
        const Media media({cloud_medium(cloud, thick ? 500.0 : 3.0, Rgb(0.0f), Rgb(1.0f), 0.85)},
                          {.max_depth = kDepths[i],
                           .threshold = thick ? 0.5 : 0.05,
                           .most_nodes = params.most_nodes});
        runs.push_back({run_paths<DeltaTracker>(media, cloud, paths),
                        run_paths<AnalogDecomposition>(media, cloud, paths)});
        const Run& delta = runs.back().delta;
        const Run& parts = runs.back().decomposition;
        const TrackCount& first = runs.front().delta.count;
        const MajorantOctree& octree = media.all().front().octree;
        table.rows.push_back({std::to_string(kDepths[i]), std::to_string(octree.depth_reached()),
                              study::grouped_digits(octree.leaf_count()),
                              decimals(static_cast<double>(octree.memory_bytes()) * 1e-6, 2),
                              millions(delta.count.leaves), millions(delta.count.lookups),
                              millions(parts.count.lookups),
                              decimals(ratio(parts.count.lookups, delta.count.lookups), 2),
                              decimals(published.decomposition[i] / published.delta[i], 2),
                              decimals(ratio(delta.count.leaves, first.leaves), 2),
                              decimals(published.leaves[i] / published.leaves[0], 2),
                              decimals(ratio(delta.count.lookups, first.lookups), 3),
                              decimals(published.delta[i] / published.delta[0], 3)});
    }
    plot_depths(params.out, table, published, runs);
    study::TextTable times = times_table(table, published, runs);
    return {std::move(table), std::move(times)};
}

}  // namespace

std::vector<study::TextTable> depth_tables(
    const std::vector<Cloud>& clouds, const VolumeStudyParams& params,
    const std::function<void(const std::string&)>& progress) {
    std::vector<study::TextTable> tables;
    for (const Cloud& cloud : clouds) {
        for (const bool thick : {false, true}) {
            progress("depth: " + cloud.name + (thick ? ", thick" : ", thin"));
            for (study::TextTable& table : depth_table(
                     cloud, thick, thick ? std::max(1, params.paths / 8) : params.paths, params)) {
                tables.push_back(std::move(table));
            }
        }
    }
    return tables;
}

}  // namespace probebake::volume_study
