#include "study/octrees/octree_figures.h"

namespace probebake::study {
namespace {

double sum(const Json& counts) {
    double total = 0.0;
    for (const Json& count : counts) total += count.get<double>();
    return total;
}

}  // namespace

double octree_figure(const Json& result, const Json& row, const std::string& quantity) {
    const auto of = [&](const char* name) { return row.at(name).get<double>(); };
    const double cast = sum(result.at("rays").at("cast"));
    if (quantity == "N_IN") return of("inner");
    if (quantity == "N_V") return of("tree_leaves");
    if (quantity == "N_EV") return of("tree_empty_leaves");
    if (quantity == "N_OIV") return of("references");
    if (quantity == "N_IT") return of("tests") / sum(result.at("rays").at("used"));
    if (quantity == "N_TS") return of("steps") / cast;
    if (quantity == "N_ETS") return of("leaves") / cast;
    if (quantity == "N_EETS") return of("empty_leaves") / cast;
    if (quantity == "N_B") return of("build_seconds");
    return of("trace_seconds");
}

const Json* find_row(const Json& result, const std::string& method, int depth) {
    for (const Json& row : result.at("rows")) {
        if (row.at("method") == method && row.at("depth") == depth) return &row;
    }
    return nullptr;
}

bool comparable(const std::string& scene, const std::string& quantity, bool full) {
    if (scene == "fluid" || quantity == "N_B" || quantity == "N_TR") return false;
    const auto tree_end = kOctreeQuantities.begin() + kTreeQuantities;
    return full || std::find(kOctreeQuantities.begin(), tree_end, quantity) != tree_end;
}

}  // namespace probebake::study
