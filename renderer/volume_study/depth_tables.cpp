#include "volume_study/depth_tables.h"

#include <chrono>

#include "track/decomposition.h"
#include "track/delta.h"
#include "track/media_line.h"
#include "volume/phase.h"

namespace probebake::volume_study {
namespace {

using Clock = std::chrono::steady_clock;
using study::decimals;

constexpr std::array<int, 4> kDepths = {1, 4, 8, 16};

/// Figures of the supplemental at kDepths, in 10⁹.
struct Published {
    std::array<double, 4> leaves;
    std::array<double, 4> delta;
    std::array<double, 4> decomposition;
};
constexpr Published kThin = {
    {0.12, 0.31, 1.32, 2.02}, {0.74, 0.24, 0.080, 0.074}, {0.74, 0.23, 0.032, 0.022}};
constexpr Published kThick = {
    {1.86, 2.06, 3.11, 4.05}, {106, 22.8, 2.96, 2.49}, {106, 22.6, 1.71, 1.03}};

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A flight's line, kept for timing its parts.
struct Flown {
    Ray ray;
    double end = 0.0;
};

struct Run {
    TrackCount count;
    double seconds = 0.0;
    double lookup_seconds = 0.0;
    double octree_seconds = 0.0;
};

/// Paths of albedo 1 through the cloud until they leave it.
template <class Tracker>
Run run_paths(const Media& media, const Cloud& cloud, int paths) {
    Run run;
    std::vector<Flown> flown;
    constexpr size_t kKept = 100000;
    const double g = media.all().front().spec.g;
    const auto start = Clock::now();
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
    run.seconds = seconds_since(start);

    // The same leaves without a tracker, and look-ups along the same lines.
    uint64_t leaves = 0;
    uint64_t lookups = 0;
    double sum = 0.0;
    Segment<1> leaf;
    const auto walk = [&](auto visit) {
        const auto from = Clock::now();
        for (const Flown& f : flown) {
            MediaLine<1> line(media, f.ray, {});
            while (line.next(leaf)) {
                visit(line);
                if (leaf.t1 > f.end) break;
            }
        }
        return seconds_since(from);
    };
    const double walking = walk([&](MediaLine<1>&) { ++leaves; });
    const double looking = walk([&](MediaLine<1>& line) {
        for (int k = 0; k < 4; ++k) {
            sum += line.at(leaf.t0 + (k + 0.5) / 4.0 * leaf.length()).scattering[0];
            ++lookups;
        }
    });
    volatile double keep = sum;
    (void)keep;
    run.octree_seconds =
        walking / static_cast<double>(leaves) * static_cast<double>(run.count.leaves);
    run.lookup_seconds = std::max(0.0, looking - walking) / static_cast<double>(lookups) *
                         static_cast<double>(run.count.lookups);
    return run;
}

std::string millions(uint64_t x) { return decimals(static_cast<double>(x) * 1e-6, 3); }

double ratio(uint64_t a, uint64_t b) { return static_cast<double>(a) / static_cast<double>(b); }

study::TextTable depth_table(const Cloud& cloud, bool thick, int paths, uint64_t most_nodes) {
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
                     "Kutz",
                     "lookup s delta",
                     "decomposition",
                     "octree s delta",
                     "decomposition",
                     "tracker s delta",
                     "decomposition"};
    const Published& published = thick ? kThick : kThin;
    TrackCount first;
    for (size_t i = 0; i < kDepths.size(); ++i) {
        const Media media(
            {cloud_medium(cloud, thick ? 500.0 : 3.0, Rgb(0.0f), Rgb(1.0f), 0.85)},
            {.max_depth = kDepths[i], .threshold = thick ? 0.5 : 0.05, .most_nodes = most_nodes});
        const Run delta = run_paths<DeltaTracker>(media, cloud, paths);
        const Run parts = run_paths<AnalogDecomposition>(media, cloud, paths);
        if (i == 0) first = delta.count;
        const MajorantOctree& octree = media.all().front().octree;
        const auto tracker = [](const Run& run) {
            return decimals(std::max(0.0, run.seconds - run.lookup_seconds - run.octree_seconds),
                            3);
        };
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
                              decimals(published.delta[i] / published.delta[0], 3),
                              decimals(delta.lookup_seconds, 3), decimals(parts.lookup_seconds, 3),
                              decimals(delta.octree_seconds, 3), decimals(parts.octree_seconds, 3),
                              tracker(delta), tracker(parts)});
    }
    return table;
}

}  // namespace

std::vector<study::TextTable> depth_tables(
    const std::vector<Cloud>& clouds, const VolumeStudyParams& params,
    const std::function<void(const std::string&)>& progress) {
    std::vector<study::TextTable> tables;
    for (const Cloud& cloud : clouds) {
        for (const bool thick : {false, true}) {
            progress("depth: " + cloud.name + (thick ? ", thick" : ", thin"));
            tables.push_back(depth_table(cloud, thick,
                                         thick ? std::max(1, params.paths / 8) : params.paths,
                                         params.most_nodes));
        }
    }
    return tables;
}

}  // namespace probebake::volume_study
