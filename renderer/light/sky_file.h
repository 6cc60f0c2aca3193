// Equirectangular pictures of skies: OpenEXR (.exr: scanlines, R, G, B) and Radiance (.hdr).
#pragma once

#include <filesystem>
#include <functional>
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

struct SkyFile {
    std::shared_ptr<const Image> image;
    std::string sha256;  // of the picture's file
};

/// The same of a file (io/file_beneath.h); IoError shows its name only, never the folder.
SkyFile read_sky_file(const std::filesystem::path& path);

/// Whoever decodes pictures: read_sky_file, or somebody who has another process do it.
using SkySource = std::function<SkyFile(const std::filesystem::path&)>;

/// A decoded picture on disk (io/checked_file.h). Both throw IoError.
void save_sky(const std::filesystem::path& path, const SkyFile& sky);
SkyFile load_sky(const std::filesystem::path& path);

}  // namespace probebake
