#include "study/octrees/havran_tables.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "io/file.h"
#include "study/text_table.h"

namespace probebake::study {
namespace {

const std::array<HavranBest, 45> kBest = {{
    {"Octree84-C",
     "balls",
     7,
     {1108, 7757, 2905, 27288, 94.75, 167.00, 24.71, 16.12, 0.29, 102.30}},
    {"Octree84-A", "balls", 5, {661, 4628, 1202, 16289, 28.62, 40.09, 8.35, 4.62, 6.17, 35.40}},
    {"Octree89-C", "balls", 7, {1108, 7757, 2905, 27288, 93.67, 97.87, 24.71, 16.12, 0.27, 67.47}},
    {"Octree93-C", "balls", 7, {1108, 7757, 2905, 27288, 89.93, 50.67, 32.34, 23.99, 0.25, 91.43}},
    {"Octree93-A", "balls", 5, {661, 4628, 1202, 16289, 26.38, 16.64, 11.41, 7.77, 0.83, 33.80}},
    {"Octree84-C", "fluid", 7, {423, 2962, 1164, 9355, 34.73, 48.18, 7.42, 2.44, 0.11, 22.85}},
    {"Octree84-A", "fluid", 5, {414, 2899, 844, 9850, 27.99, 37.40, 7.64, 2.87, 2.54, 20.74}},
    {"Octree89-C", "fluid", 7, {423, 2962, 1164, 9355, 34.57, 29.55, 7.43, 2.44, 0.09, 18.80}},
    {"Octree93-C", "fluid", 7, {423, 2962, 1164, 9353, 31.21, 16.65, 11.50, 6.70, 0.10, 22.00}},
    {"Octree93-A", "fluid", 5, {414, 2899, 844, 9850, 24.61, 15.36, 11.42, 6.87, 0.34, 19.57}},
    {"Octree84-C", "gears", 5, {1405, 9836, 4088, 85832, 71.38, 46.49, 8.33, 4.64, 0.46, 247.00}},
    {"Octree84-A", "gears", 5, {349, 2444, 580, 31144, 68.78, 23.50, 5.15, 2.60, 0.79, 206.60}},
    {"Octree89-C", "gears", 5, {1405, 9836, 4088, 85832, 72.33, 34.16, 8.33, 4.65, 0.38, 229.00}},
    {"Octree93-C", "gears", 5, {1405, 9836, 4088, 85832, 69.62, 18.71, 11.40, 7.80, 0.40, 246.10}},
    {"Octree93-A", "gears", 4, {349, 2444, 580, 31144, 65.44, 11.70, 7.11, 4.63, 0.92, 210.90}},
    {"Octree84-C", "lattice", 5, {4681, 32768, 7744, 49600, 13.80, 47.88, 7.98, 1.71, 0.39, 56.37}},
    {"Octree84-A", "lattice", 5, {4681, 32768, 7133, 42789, 9.97, 46.89, 7.82, 2.65, 1.23, 49.32}},
    {"Octree89-C", "lattice", 7, {4681, 32768, 7744, 49600, 13.70, 31.24, 7.98, 1.71, 0.34, 45.22}},
    {"Octree93-C",
     "lattice",
     5,
     {4681, 32768, 7744, 49600, 12.32, 17.68, 12.46, 6.67, 0.38, 55.45}},
    {"Octree93-A", "lattice", 4, {4681, 32768, 7133, 42789, 8.99, 17.62, 11.25, 6.48, 1.45, 50.15}},
    {"Octree84-C", "mount", 6, {1019, 7134, 3060, 34351, 23.72, 30.89, 6.08, 2.33, 0.25, 32.40}},
    {"Octree84-A", "mount", 5, {1534, 10739, 3615, 47351, 17.58, 29.26, 5.77, 2.51, 1.01, 28.34}},
    {"Octree89-C", "mount", 6, {1019, 7134, 3060, 34351, 23.50, 23.54, 6.09, 2.34, 0.22, 28.27}},
    {"Octree93-C", "mount", 5, {1019, 7134, 3060, 34351, 22.61, 13.37, 9.09, 5.46, 0.24, 32.71}},
    {"Octree93-A", "mount", 4, {1531, 10718, 3605, 47338, 16.56, 12.72, 8.30, 5.15, 1.18, 29.24}},
    {"Octree84-C",
     "rings",
     6,
     {6925, 48476, 10281, 133929, 35.12, 81.90, 13.38, 6.69, 0.64, 111.80}},
    {"Octree84-A", "rings", 5, {2055, 14386, 1718, 54320, 32.11, 44.74, 8.55, 3.92, 1.21, 86.47}},
    {"Octree89-C",
     "rings",
     6,
     {6925, 48476, 10281, 133929, 35.12, 52.46, 13.38, 6.69, 0.54, 94.38}},
    {"Octree93-C",
     "rings",
     4,
     {6925, 48476, 10281, 133929, 34.87, 28.59, 19.43, 12.78, 0.57, 108.80}},
    {"Octree93-A", "rings", 5, {2055, 14386, 1718, 54320, 31.81, 18.65, 12.56, 7.96, 1.38, 87.69}},
    {"Octree84-C",
     "teapot",
     6,
     {4100, 28701, 12327, 83551, 45.63, 64.67, 11.69, 8.61, 0.47, 30.72}},
    {"Octree84-A",
     "teapot",
     6,
     {4100, 28701, 12327, 83551, 45.63, 64.67, 11.69, 8.61, 0.47, 30.72}},
    {"Octree89-C",
     "teapot",
     6,
     {4100, 28701, 12327, 83551, 45.77, 43.95, 11.70, 8.61, 0.45, 22.97}},
    {"Octree93-C",
     "teapot",
     6,
     {4100, 28701, 12327, 83551, 44.21, 23.31, 14.34, 11.33, 0.43, 27.78}},
    {"Octree93-A", "teapot", 5, {1703, 11922, 3460, 59055, 47.91, 19.16, 11.91, 9.19, 1.46, 25.33}},
    {"Octree84-C", "tetra", 5, {1369, 9584, 4764, 32768, 63.58, 32.08, 6.20, 4.48, 0.17, 6.34}},
    {"Octree84-A", "tetra", 6, {6449, 45144, 20976, 120336, 23.03, 33.72, 6.26, 5.33, 1.25, 5.05}},
    {"Octree89-C", "tetra", 5, {1369, 9584, 4764, 32768, 63.66, 23.91, 6.23, 4.51, 0.16, 5.23}},
    {"Octree93-C", "tetra", 5, {1369, 9584, 4764, 32768, 61.11, 12.70, 7.66, 5.99, 0.16, 5.83}},
    {"Octree93-A", "tetra", 5, {6413, 44892, 20784, 120048, 24.08, 13.85, 7.36, 6.38, 1.42, 4.94}},
    {"Octree84-C", "tree", 7, {352, 2465, 1801, 13725, 741.30, 219.30, 32.74, 23.33, 0.29, 338.20}},
    {"Octree84-A", "tree", 7, {4300, 30101, 11205, 44516, 24.33, 45.84, 10.16, 6.95, 1.42, 34.84}},
    {"Octree89-C", "tree", 7, {352, 2465, 1801, 13725, 742.00, 130.10, 32.74, 23.34, 0.27, 288.50}},
    {"Octree93-C", "tree", 7, {352, 2465, 1801, 13725, 738.00, 65.90, 41.63, 32.40, 0.28, 317.60}},
    {"Octree93-A", "tree", 7, {4301, 30108, 11205, 44514, 23.79, 18.46, 13.12, 9.96, 1.65, 29.90}},
}};

const std::array<HavranRays, 8> kRays = {{
    {"balls", {263169, 179884, 959244}, {263169, 134368, 285178}},
    {"gears", {263169, 494338, 2088012}, {245332, 365338, 1057557}},
    {"lattice", {263169, 243210, 1180774}, {261170, 178786, 943159}},
    {"mount", {263169, 710436, 361037}, {173685, 472351, 74555}},
    {"rings", {263169, 312879, 1077336}, {263169, 175688, 510719}},
    {"teapot", {263169, 226235, 406340}, {161546, 67688, 34757}},
    {"tetra", {263169, 0, 46262}, {49950, 0, 5538}},
    {"tree", {263169, 0, 1110323}, {169907, 0, 47506}},
}};

std::vector<std::string_view> split(std::string_view line) {
    std::vector<std::string_view> cells;
    for (;;) {
        const size_t comma = line.find(',');
        cells.push_back(line.substr(0, comma));
        if (comma == std::string_view::npos) return cells;
        line.remove_prefix(comma + 1);
    }
}

template <class T>
bool parse(std::string_view text, T& value) {
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && rest == text.data() + text.size();
}

/// How many of a column's values are those of a method table; build and trace time included.
int matches(const HavranTables& tables, const HavranBest& best, const std::string& method,
            int depth) {
    int count = 0;
    for (size_t i = 0; i < kOctreeQuantities.size(); ++i) {
        const auto value = tables.value(method, best.scene, depth, kOctreeQuantities[i]);
        if (value && *value == best.values[i]) ++count;
    }
    return count;
}

constexpr int kAll = static_cast<int>(kOctreeQuantities.size());

std::string contradiction(const HavranTables& tables, const HavranBest& best) {
    const std::string column = std::string(best.scene) + " " + best.method;
    const std::string label = "depth " + std::to_string(best.depth);
    for (int depth = 4; depth <= 7; ++depth) {
        if (depth != best.depth && matches(tables, best, best.method, depth) == kAll) {
            return (column + ": headed ")
                .append(label)
                .append(", values of depth ")
                .append(std::to_string(depth));
        }
    }
    for (const char* method : kOctreeMethods) {
        if (method != std::string(best.method) &&
            matches(tables, best, method, best.depth) == kAll) {
            return column + ": repeats " + method;
        }
    }
    std::string text = column + ", " + label + ":";
    const char* separator = " ";
    for (size_t i = 0; i < kOctreeQuantities.size(); ++i) {
        const auto value = tables.value(best.method, best.scene, best.depth, kOctreeQuantities[i]);
        if (value && *value == best.values[i]) continue;
        text += separator + std::string(kOctreeQuantities[i]) + " " + decimals(best.values[i], 2) +
                ", in the method's table " + decimals(value, 2);
        separator = "; ";
    }
    return text;
}

}  // namespace

HavranTables::HavranTables(const std::filesystem::path& csv) {
    const std::vector<std::byte> bytes = read_file(csv, uint64_t{1} << 24);
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    for (int number = 1; !text.empty(); ++number) {
        const size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        const std::vector<std::string_view> cells = split(line);
        int depth = 0;
        double value = 0.0;
        if (number == 1 && line == "method,scene,maxdepth,quantity,value") continue;
        if (number == 1 || cells.size() != 5 || !parse(cells[2], depth) ||
            !parse(cells[4], value) || !std::isfinite(value)) {
            throw IoError(csv.filename().string(),
                          "line " + std::to_string(number) +
                              ": expected method,scene,maxdepth,quantity,value");
        }
        values_[{std::string(cells[0]), std::string(cells[1]), depth, std::string(cells[3])}] =
            value;
    }
}

std::optional<double> HavranTables::value(const std::string& method, const std::string& scene,
                                          int depth, const std::string& quantity) const {
    const auto found = values_.find({method, scene, depth, quantity});
    if (found == values_.end()) return std::nullopt;
    return found->second;
}

const std::array<HavranBest, 45>& havran_best() { return kBest; }
const std::array<HavranRays, 8>& havran_rays() { return kRays; }

std::vector<std::string> comparison_contradictions(const HavranTables& tables) {
    std::vector<std::string> found;
    for (const HavranBest& best : kBest) {
        if (matches(tables, best, best.method, best.depth) == kAll) continue;
        found.push_back(contradiction(tables, best));
    }
    return found;
}

std::vector<std::string> tree_contradictions(const HavranTables& tables) {
    std::vector<std::string> found;
    constexpr std::array<std::pair<const char*, const char*>, 3> kSameTree = {
        {{"Octree84-C", "Octree89-C"}, {"Octree84-C", "Octree93-C"}, {"Octree84-A", "Octree93-A"}}};
    for (const auto& [a, b] : kSameTree) {
        for (const char* scene : kOctreeScenes) {
            for (int depth = 4; depth <= 7; ++depth) {
                for (size_t i = 0; i < kTreeQuantities; ++i) {
                    const auto in_a = tables.value(a, scene, depth, kOctreeQuantities[i]);
                    const auto in_b = tables.value(b, scene, depth, kOctreeQuantities[i]);
                    if (!in_a || !in_b || *in_a == *in_b) continue;
                    found.push_back(std::string(scene) + ", depth " + std::to_string(depth) + ", " +
                                    kOctreeQuantities[i] + ": " + decimals(*in_a, 0) + " in " + a +
                                    ", " + decimals(*in_b, 0) + " in " + b);
                }
            }
        }
    }
    return found;
}

}  // namespace probebake::study
