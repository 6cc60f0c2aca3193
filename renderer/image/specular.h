// What mirrors of growing roughness reflect, for engines that look it up by roughness and
// direction: a chain of cubemaps, each half as wide as the one before.
//
// With M mips, mip m is N >> m wide (at least 16; M = 1 below 32), of perceptual roughness m/(M−1),
// α = roughness²; mip 0 is the cubemap itself. A texel holds the light of a GGX lobe seen along the
// normal, N = V = R, weighed by n·l (the first factor of the split sum: Karis 2013, "Real Shading
// in Unreal Engine 4"), on the grid of cubemap.h, shared edges and all. A constant is exact.
#pragma once

#include "image/sphere_filter.h"

namespace probebake {

inline constexpr int kSmallestSpecularFace_px = 16;

/// Mips of the chain of a cubemap of n pixels per face.
constexpr int specular_mips(int face_size_px) {
    int mips = 1;
    while (face_size_px >> mips >= kSmallestSpecularFace_px) ++mips;
    return mips;
}

/// Perceptual; 0 for a chain of one.
constexpr double specular_roughness(int mip, int mips) {
    return mips > 1 ? static_cast<double>(mip) / (mips - 1) : 0.0;
}

/// The light of GGX lobes of this α > 0 on a cubemap of `face_size_px`.
Cubemap specular_of(const SphereFilter& cubemap, double alpha, int face_size_px);

}  // namespace probebake
