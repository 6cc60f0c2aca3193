#include "scene/generators/erosion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <utility>

namespace probebake::worldgen {
namespace {

constexpr int kFinestSide = 256;  // cells of 2.5 m
constexpr std::array<std::pair<int, int>, 3> kStages = {
    {{64, 24}, {128, 14}, {kFinestSide, 8}}};  // side, steps
constexpr int kStepsPerFlood = 2;              // rivers change their course slowly

constexpr std::array<std::array<int, 2>, 8> kNeighbours = {
    {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};

/// Every cell after the cell that it drains into.
struct Flow {
    std::vector<size_t> order;
    std::vector<size_t> receiver;
};

/// Cells in the order in which water rising from the border would reach them.
Flow priority_flood(const Grid& height) {
    const int side = height.side();
    const size_t count = height.values().size();
    Flow flow;
    flow.order.reserve(count);
    flow.receiver.assign(count, count);
    using Entry = std::pair<double, size_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
    for (size_t i = 0; i < count; ++i) {
        const int x = static_cast<int>(i) % side;
        const int z = static_cast<int>(i) / side;
        if (x == 0 || z == 0 || x == side - 1 || z == side - 1) {
            flow.receiver[i] = i;
            front.emplace(height.values()[i], i);
        }
    }
    while (!front.empty()) {
        const auto [level, cell] = front.top();
        front.pop();
        flow.order.push_back(cell);
        const int x = static_cast<int>(cell) % side;
        const int z = static_cast<int>(cell) / side;
        for (const auto& [dx, dz] : kNeighbours) {
            if (x + dx < 0 || z + dz < 0 || x + dx >= side || z + dz >= side) continue;
            const auto next = static_cast<size_t>(z + dz) * static_cast<size_t>(side) +
                              static_cast<size_t>(x + dx);
            if (flow.receiver[next] != count) continue;
            flow.receiver[next] = cell;
            front.emplace(std::max(level, height.values()[next]), next);
        }
    }
    return flow;
}

Grid drainage_area(const Grid& height, const Flow& flow) {
    Grid area(height.side(), height.cell_m() * height.cell_m());
    for (size_t i = flow.order.size(); i-- > 0;) {
        const size_t cell = flow.order[i];
        if (flow.receiver[cell] != cell) {
            area.values()[flow.receiver[cell]] += area.values()[cell];
        }
    }
    return area;
}

void wear_down(Grid& height, const Flow& flow, const Grid& fixed, const Grid& stable_slope,
               double strength) {
    const Grid area = drainage_area(height, flow);
    const int side = height.side();
    for (const size_t cell : flow.order) {
        const size_t receiver = flow.receiver[cell];
        if (receiver == cell || fixed.values()[cell] > 0.0) continue;
        const int x = static_cast<int>(cell) % side;
        const int z = static_cast<int>(cell) / side;
        const bool diagonal = receiver % static_cast<size_t>(side) != static_cast<size_t>(x) &&
                              receiver / static_cast<size_t>(side) != static_cast<size_t>(z);
        const double run = height.cell_m() * (diagonal ? std::sqrt(2.0) : 1.0);
        double& h = height.values()[cell];
        const double below = height.values()[receiver];
        if (h < below) {
            h = below;  // silt fills a pit
            continue;
        }
        const double wear = strength * std::sqrt(area.values()[cell]) / run;
        h = (h + wear * below) / (1.0 + wear);
        h = std::min(h, below + stable_slope.values()[cell] * run);
    }
}

}  // namespace

Grid erode(const std::function<double(const Vec2&)>& initial_height_m,
           const ErosionParams& params) {
    Grid height(kStages.front().first, initial_height_m);
    for (const auto& [side, steps] : kStages) {
        if (side != height.side()) {
            // The finer grid starts from what was worn away so far and adds its own relief.
            const Grid coarse = std::move(height);
            const Grid before(coarse.side(), initial_height_m);
            height = Grid(side, [&](const Vec2& at) {
                return coarse.sample(at) + initial_height_m(at) - before.sample(at);
            });
        }
        const Grid fixed(side, [&](const Vec2& at) { return params.fixed(at) ? 1.0 : 0.0; });
        for (int i = 0; i < steps; i += kStepsPerFlood) {
            const Flow flow = priority_flood(height);
            const Grid stable_slope(
                side, [&](const Vec2& at) { return params.talus(at, height.nearest_value(at)); });
            for (int k = 0; k < kStepsPerFlood; ++k) {
                wear_down(height, flow, fixed, stable_slope, params.strength);
            }
        }
    }
    return height;
}

}  // namespace probebake::worldgen
