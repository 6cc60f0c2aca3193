// Morton codes: bits of x, y, z interleaved, x lowest (… z1 y1 x1 z0 y0 x0).
//
// 16 bits per axis, so 48 bits in all: 16 octree levels, a world of 65,536³ voxels. The lowest
// three bits are the octant of the parent (bit = x + 2y + 4z), as in Müller 2020, 3.1.
#pragma once

#include <cstdint>

#include "math/vec.h"

namespace probebake {

inline constexpr int kMortonBitsPerAxis = 16;

namespace detail {
/// Spreads the low 16 bits so that bit i lands on bit 3i.
constexpr uint64_t spread3(uint64_t v) {
    v &= 0xFFFF;
    v = (v | (v << 16)) & 0x0000'0000'FF00'00FF;
    v = (v | (v << 8)) & 0x0000'00F0'0F00'F00F;
    v = (v | (v << 4)) & 0x0000'0C30'C30C'30C3;
    v = (v | (v << 2)) & 0x0000'2492'4924'9249;
    return v;
}

constexpr uint32_t compact3(uint64_t v) {
    v &= 0x0000'2492'4924'9249;
    v = (v | (v >> 2)) & 0x0000'0C30'C30C'30C3;
    v = (v | (v >> 4)) & 0x0000'00F0'0F00'F00F;
    v = (v | (v >> 8)) & 0x0000'0000'FF00'00FF;
    v = (v | (v >> 16)) & 0x0000'0000'0000'FFFF;
    return static_cast<uint32_t>(v);
}
}  // namespace detail

/// Code of a voxel; every coordinate in [0, 65535].
constexpr uint64_t morton_encode(uint32_t x, uint32_t y, uint32_t z) {
    return detail::spread3(x) | (detail::spread3(y) << 1) | (detail::spread3(z) << 2);
}

inline IVec3 morton_decode(uint64_t code) {
    return {static_cast<int>(detail::compact3(code)), static_cast<int>(detail::compact3(code >> 1)),
            static_cast<int>(detail::compact3(code >> 2))};
}

}  // namespace probebake
