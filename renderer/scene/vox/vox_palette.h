// Colours of a .vox file: palette and materials in, linear reflectance and radiance out.
//
// Palette entries are sRGB (IEC 61966-2-1); their alpha is not used. MagicaVoxel's documentation
// gives "emission" and "power" (`_emit`, `_flux`) no unit. Radiance is taken as
//
//   L = linear colour · _emit · 10^(_flux − 1)   W·m⁻²·sr⁻¹
//
// the scale of the readers that convert between these two and an emission in decades (Teardown's,
// in metarmask/teardown, editor-format/src/tests.rs, and in vengi, TeardownFormat.cpp): at power 1
// and full emission a voxel shines as brightly as its colour. Absent, both count as 0. `_ldr`
// darkens emitters for the camera only, not what they light, and is ignored.
#pragma once

#include <array>
#include <cstdint>

#include "math/shared_exponent.h"

namespace probebake {

/// sRGB and alpha by colour index; index 0 is empty space.
using VoxPalette = std::array<std::array<uint8_t, 4>, 256>;

/// What is taken of a MATL chunk; 0 for what does not shine.
struct VoxMaterial {
    double emit = 0.0;  // 0..1 in MagicaVoxel's editor
    double flux = 0.0;  // 0..4 there
};
using VoxMaterials = std::array<VoxMaterial, 256>;

/// Limits that keep a radiance representable, far beyond what MagicaVoxel writes.
inline constexpr double kMaxVoxEmit = 1000.0;
inline constexpr double kMaxVoxFlux = 10.0;

/// The palette of a file without RGBA chunk.
VoxPalette default_vox_palette();

struct VoxColors {
    std::array<PackedRgb, 256> albedo{};
    std::array<PackedRgb, 256> emission{};  // radiance / emission_scale
    /// A power of two that brings the brightest component into [2^14, 2^15), the upper part of
    /// the packed range; 1 where nothing shines.
    float emission_scale = 1.0f;
};
VoxColors linear_colors(const VoxPalette& palette, const VoxMaterials& materials);

}  // namespace probebake
