#include <cmath>

#include "study/octrees/octree_figures.h"
#include "study/octrees/octree_report.h"

namespace probebake::study {
namespace {

/// The scenes whose rays the design's prototype met within 1.4 %; the refraction of mount and gears
/// is not the same program's.
constexpr std::array<const char*, 6> kScenesOfSteps = {"balls",  "lattice", "rings",
                                                       "teapot", "tetra",   "tree"};

/// Each figure of a method beside that of 1999: visit(ours, theirs).
template <class Visit>
void for_each_figure(const HavranTables& tables, const Json& results, const std::string& method,
                     const std::string& quantity, bool full, Visit visit) {
    for (const auto& [scene, result] : results.items()) {
        if (!comparable(scene, quantity, full)) continue;
        for (const Json& row : result.at("rows")) {
            if (row.at("method") != method) continue;
            const int depth = row.at("depth").get<int>();
            const auto theirs = tables.value(method, scene, depth, quantity);
            if (theirs) visit(scene, depth, octree_figure(result, row, quantity), *theirs);
        }
    }
}

double relative(double ours, double theirs) {
    return theirs == 0.0 ? (ours == 0.0 ? 0.0 : kInfinity) : ours / theirs - 1.0;
}

double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// How the counts of trees compare: how many there are, how many are exact, the others' deviations.
Json tree_counts(const HavranTables& tables, const Json& results, const char* method) {
    uint64_t count = 0;
    uint64_t exact = 0;
    std::vector<double> off;
    for (size_t i = 0; i < kTreeQuantities; ++i) {
        for_each_figure(tables, results, method, kOctreeQuantities[i], false,
                        [&](const std::string&, int, double ours, double theirs) {
                            ++count;
                            if (ours == theirs) ++exact;
                            off.push_back(std::abs(relative(ours, theirs)));
                        });
    }
    return {{"count", count},
            {"exact", exact},
            {"median_off", median(off)},
            {"largest_off", off.empty() ? 0.0 : *std::max_element(off.begin(), off.end())}};
}

/// Glassner's steps per ray against 1999's: the largest deviation of each scene.
Json steps_off(const HavranTables& tables, const Json& results) {
    Json off = Json::object();
    for_each_figure(tables, results, "Octree84-C", "N_TS", true,
                    [&](const std::string& scene, int, double ours, double theirs) {
                        const double here = relative(ours, theirs);
                        const double most = off.value(scene, 0.0);
                        if (std::abs(here) > std::abs(most)) off[scene] = here;
                    });
    return off;
}

/// N_TS of a method over that of Glassner's, ours against 1999's: the largest difference.
double ratio_off(const HavranTables& tables, const Json& results, const char* method) {
    double most = 0.0;
    for_each_figure(tables, results, method, "N_TS", true,
                    [&](const std::string& scene, int depth, double ours, double theirs) {
                        const Json& result = results.at(scene);
                        const Json* glassner = find_row(result, "Octree84-C", depth);
                        const auto theirs_84 = tables.value("Octree84-C", scene, depth, "N_TS");
                        if (glassner == nullptr || !theirs_84) return;
                        const double ratio = ours / octree_figure(result, *glassner, "N_TS");
                        most = std::max(most, std::abs(ratio - theirs / *theirs_84));
                    });
    return most;
}

/// CPU time of a method over that of Glassner's on the same tree, over all scenes and depths.
Json cpu_ratio(const Json& results, const std::string& method, const std::string& glassner) {
    std::vector<double> ratios;
    for (const auto& [scene, result] : results.items()) {
        for (const Json& row : result.at("rows")) {
            if (row.at("method") != method) continue;
            const Json* base = find_row(result, glassner, row.at("depth").get<int>());
            if (base == nullptr) continue;
            ratios.push_back(octree_figure(result, row, "N_TR") /
                             octree_figure(result, *base, "N_TR"));
        }
    }
    if (ratios.empty()) return nullptr;
    const auto [least, most] = std::minmax_element(ratios.begin(), ratios.end());
    const auto faster =
        std::count_if(ratios.begin(), ratios.end(), [](double r) { return r < 1.0; });
    return {{"least", *least},
            {"median", median(ratios)},
            {"most", *most},
            {"faster", faster},
            {"cases", ratios.size()}};
}

}  // namespace

Json summarise_octrees(const HavranTables& tables, const Json& results, bool full) {
    Json summary = {{"center_counts", tree_counts(tables, results, "Octree84-C")},
                    {"cost_counts", tree_counts(tables, results, "Octree84-A")},
                    {"cpu_89", cpu_ratio(results, "Octree89-C", "Octree84-C")},
                    {"cpu_93", cpu_ratio(results, "Octree93-C", "Octree84-C")},
                    {"cpu_93_cost", cpu_ratio(results, "Octree93-A", "Octree84-A")}};
    uint64_t casts = 0;
    uint64_t disagreements = 0;
    uint64_t changed_hits = 0;
    for (const auto& [scene, result] : results.items()) {
        uint64_t rays = 0;
        for (const Json& count : result.at("rays").at("cast")) rays += count.get<uint64_t>();
        casts += rays * result.at("rows").size();
        disagreements += result.at("disagreements").get<uint64_t>();
        changed_hits += result.at("changed_hits").get<uint64_t>();
    }
    summary["casts"] = casts;
    summary["disagreements"] = disagreements;
    summary["changed_hits"] = changed_hits;
    if (!full) return summary;
    const Json off = steps_off(tables, results);
    double most = 0.0;
    for (const char* scene : kScenesOfSteps) most = std::max(most, std::abs(off.value(scene, 0.0)));
    summary["steps_off"] = off;
    summary["steps_off_of_six"] = most;
    summary["ratio_off_89"] = ratio_off(tables, results, "Octree89-C");
    summary["ratio_off_93"] = ratio_off(tables, results, "Octree93-C");
    return summary;
}

}  // namespace probebake::study
