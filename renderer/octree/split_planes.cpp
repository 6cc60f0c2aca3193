#include "octree/split_planes.h"

namespace probebake {
namespace {

/// Mean of the centres of the items' parts within the box.
double object_median(std::span<const AxisInterval> items, const AxisInterval& side) {
    double sum = 0.0;
    for (const AxisInterval& item : items) {
        sum += 0.5 * (std::max(item.low, side.low) + std::min(item.high, side.high));
    }
    return std::clamp(sum / static_cast<double>(items.size()), side.low, side.high);
}

}  // namespace

double split_cost(std::span<const AxisInterval> items, const AxisInterval& side, double position,
                  double b, double c) {
    uint64_t left = 0;
    uint64_t right = 0;
    for (const AxisInterval& item : items) {
        if (item.high <= position) {
            ++left;
        } else if (item.low >= position) {
            ++right;
        }
    }
    const uint64_t cut = items.size() - left - right;
    const double a = side.high - side.low;
    const double t = position - side.low;
    return static_cast<double>(left + cut) * (2.0 * t * (b + c) + b * c) +
           static_cast<double>(right + cut) * (2.0 * (a - t) * (b + c) + b * c);
}

Vec3 center_planes(const Box& box) { return 0.5 * (box.low + box.high); }

Vec3 cost_planes(const Box& box, std::span<const uint32_t> items, std::span<const Box> item_boxes) {
    Vec3 planes = center_planes(box);
    std::vector<AxisInterval> intervals(items.size());
    const Vec3 size = box.high - box.low;
    for (int axis = 0; axis < 3; ++axis) {
        for (size_t i = 0; i < items.size(); ++i) {
            const Box& item = item_boxes[items[i]];
            intervals[i] = {item.low[axis], item.high[axis]};
        }
        const AxisInterval side{box.low[axis], box.high[axis]};
        const double spatial = planes[axis];
        const double median = object_median(intervals, side);
        double lowest = kInfinity;
        for (int k = 0; k < kCostPositions; ++k) {
            const double share = static_cast<double>(k) / kCostPositions;
            const double position = spatial + share * (median - spatial);
            const double cost =
                split_cost(intervals, side, position, size[(axis + 1) % 3], size[(axis + 2) % 3]);
            if (cost < lowest) {
                lowest = cost;
                planes[axis] = position;
            }
        }
    }
    return planes;
}

}  // namespace probebake
