// The six axis directions, in the order that cubemap faces, voxel faces and files share.
#pragma once

#include <array>
#include <cstdint>

namespace probebake {

enum class CubeFace : uint8_t { kPosX, kNegX, kPosY, kNegY, kPosZ, kNegZ };

inline constexpr int kFaceCount = 6;
inline constexpr std::array<CubeFace, kFaceCount> kCubeFaces = {CubeFace::kPosX, CubeFace::kNegX,
                                                                CubeFace::kPosY, CubeFace::kNegY,
                                                                CubeFace::kPosZ, CubeFace::kNegZ};
inline constexpr std::array<const char*, kFaceCount> kFaceNames = {"+X", "-X", "+Y",
                                                                   "-Y", "+Z", "-Z"};

constexpr int index_of(CubeFace face) { return static_cast<int>(face); }
constexpr int axis_of(CubeFace face) { return index_of(face) / 2; }

}  // namespace probebake
