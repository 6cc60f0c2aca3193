// Lighting states as JSON.
#pragma once

#include "bake/lighting_state.h"
#include "io/json.h"

namespace probebake {

/// One of "albedo" and "emission", or the object of a lit state. Problems go to `issues`.
LightingState read_state(const Json& value, const std::string& pointer, JsonIssues& issues);
Json write_state_spec(const LightingState& state);

}  // namespace probebake
