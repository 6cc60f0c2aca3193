// The tables of Havran, "Comparison of Octree Traversal Algorithms", 1999, and what they say of
// themselves.
//
// The method tables come from a CSV file of 1,800 values (method,scene,maxdepth,quantity,value);
// the comparison table, 45 columns of best settings, stands here.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace probebake::study {

inline constexpr std::array<const char*, 5> kOctreeMethods = {
    "Octree84-C", "Octree84-A", "Octree89-C", "Octree93-C", "Octree93-A"};
inline constexpr std::array<const char*, 9> kOctreeScenes = {
    "balls", "fluid", "gears", "lattice", "mount", "rings", "teapot", "tetra", "tree"};
inline constexpr std::array<const char*, 10> kOctreeQuantities = {
    "N_IN", "N_V", "N_EV", "N_OIV", "N_IT", "N_TS", "N_ETS", "N_EETS", "N_B", "N_TR"};
/// Of kOctreeQuantities, those that a tree has before a ray is cast.
inline constexpr size_t kTreeQuantities = 4;

class HavranTables {
  public:
    /// Throws IoError with the line where the file is not such a table.
    explicit HavranTables(const std::filesystem::path& csv);

    std::optional<double> value(const std::string& method, const std::string& scene, int depth,
                                const std::string& quantity) const;
    size_t size() const { return values_.size(); }

  private:
    std::map<std::tuple<std::string, std::string, int, std::string>, double> values_;
};

/// A column of the comparison table: the best setting of a method for a scene.
struct HavranBest {
    const char* method;
    const char* scene;
    int depth;  // as its heading says
    std::array<double, 10> values;
};
const std::array<HavranBest, 45>& havran_best();

/// Where the comparison table disagrees with the method tables, one sentence each.
std::vector<std::string> comparison_contradictions(const HavranTables& tables);
/// Where method tables disagree that must have been made with the same tree.
std::vector<std::string> tree_contradictions(const HavranTables& tables);

/// Rays of the same program on the same scenes: V. Havran and F. Sixta, "Comparison of hierarchical
/// grids", 1999 (docs/havran_stats_grids.txt of the SPD), by the kinds of spd_rays.h.
struct HavranRays {
    const char* scene;
    std::array<uint64_t, 3> cast;  // eye, secondary, shadow
    std::array<uint64_t, 3> used;
};
const std::array<HavranRays, 8>& havran_rays();

}  // namespace probebake::study
