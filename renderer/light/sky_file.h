// Equirectangular pictures of skies: OpenEXR (.exr: scanlines, R, G, B) and Radiance (.hdr).
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "image/image.h"

namespace probebake {

inline constexpr uint64_t kMaxSkyFileBytes = uint64_t{256} << 20;
inline constexpr int kMaxSkyWidth_px = 8192;

/// Reads a picture; the kind is told by its first bytes. Throws IoError with `name` for a file that
/// is neither, is damaged, is not twice as wide as high or wider than kMaxSkyWidth_px, or holds a
/// value that is negative or not finite.
std::shared_ptr<const Image> decode_sky(std::span<const std::byte> bytes, const std::string& name);

/// The same of a file; IoError shows its name only, never the folder.
std::shared_ptr<const Image> read_sky(const std::filesystem::path& path);

}  // namespace probebake
