// Rivers and slides that shape a height field.
//
// erode() lowers a height field by stream power, dh/dt = −K·A^½·|∇h| with drainage area A, solved
// implicitly from the outlets upstream (Braun and Willett 2013, "A very efficient O(n), implicit
// and parallel method to solve the stream power equation"), on receivers found by a priority
// flood, so that no pit stops a river (Barnes et al. 2014, "Priority-flood"). Slopes steeper than
// the talus slope slide. From coarse to fine grids: valleys form first, gullies later.
// The grid covers the world and a margin around it, whose border holds the outlets.
#pragma once

#include <functional>

#include "scene/generators/grid.h"

namespace probebake::worldgen {

struct ErosionParams {
    double strength = 0.02;  // K·Δt of each of the 46 steps
    /// Steepest stable slope (rise over run) of the ground at a height.
    std::function<double(const Vec2& at_m, double height_m)> talus;
    /// Ground that is not worn away: still water, a valley floor kept for a town.
    std::function<bool(const Vec2& at_m)> fixed;
};

/// The heights that are left, in metres.
Grid erode(const std::function<double(const Vec2&)>& initial_height_m, const ErosionParams& params);

}  // namespace probebake::worldgen
