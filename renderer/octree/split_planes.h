// Where a node is split: in the middle, or where a cost estimate is lowest.
//
// The estimate (Whang et al. 1995; MacDonald and Booth 1990; as Havran 1999 states it): a box of
// a × b × c that is split at t on the axis of a costs
//
//     (left + cut) (2t(b + c) + bc) + (right + cut) (2(a − t)(b + c) + bc)
//
// left, right and cut being the items on either side and across; a face area each (half of it for
// the ends), times the items behind it. Each axis is taken on its own. Ten positions between the
// spatial and the object median are tried.
#pragma once

#include <span>
#include <vector>

#include "math/box.h"

namespace probebake {

enum class SplitPlanes : uint8_t { kCenter, kCostEstimate };

inline constexpr int kCostPositions = 10;

/// Items of one axis: where each begins and ends.
struct AxisInterval {
    double low = 0.0;
    double high = 0.0;
};

/// The estimate for a plane at `low + t` of a box of side a on this axis, b and c on the others.
/// An item that ends at the plane is left of it, one that begins there right, one that lies in it
/// left.
double split_cost(std::span<const AxisInterval> items, const AxisInterval& side, double position,
                  double b, double c);

Vec3 center_planes(const Box& box);
/// The cheapest of kCostPositions evenly spaced positions from the spatial median on towards the
/// object median, which itself is left out; the first of equals. The object median is the mean of
/// the centres of the items' parts within the box. Havran 1999 says none of this; of the readings
/// that were tried this one comes nearest to its tables (docs/results/octrees.md).
Vec3 cost_planes(const Box& box, std::span<const uint32_t> items, std::span<const Box> item_boxes);

}  // namespace probebake
