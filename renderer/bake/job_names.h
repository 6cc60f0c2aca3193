// The words of requests and reports, in the order of the enumerations.
#pragma once

#include <array>
#include <string_view>

#include "bake/job_spec.h"

namespace probebake {

inline constexpr std::array<std::string_view, 2> kStateNames = {"albedo", "emission"};
inline constexpr std::array<std::string_view, 6> kMetricNames = {
    "psnr_db", "rmse", "ssim", "rays", "irradiance_rel", "rel_mse"};
inline constexpr std::array<std::string_view, 2> kRequireNames = {"all", "any"};
inline constexpr std::array<std::string_view, 2> kAgainstNames = {"truth", "reference"};
/// Those of RendererKind that a client may name, then "auto": the plan chooses.
inline constexpr std::array<std::string_view, 6> kRendererNames = {
    "reference", "lod", "adaptive", "error_aware", "hybrid", "auto"};
inline constexpr std::array<std::string_view, 2> kWeightingNames = {"uniform", "solid_angle"};
inline constexpr std::array<std::string_view, 2> kOnBudgetExhaustedNames = {"return_best", "fail"};
inline constexpr std::array<std::string_view, 2> kMissesNames = {"left_out", "black"};
inline constexpr std::array<std::string_view, 7> kProductNames = {
    "cube", "aux", "latlong", "gl_faces", "sh", "specular", "ddgi"};
/// In the same order.
inline constexpr std::array<bool Products::*, 7> kProductFlags = {
    &Products::cube, &Products::aux,      &Products::latlong, &Products::gl_faces,
    &Products::sh,   &Products::specular, &Products::ddgi};

}  // namespace probebake
