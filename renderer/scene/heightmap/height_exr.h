// Heights as an OpenEXR picture of one channel, HALF or FLOAT.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace probebake {

struct HeightPicture {
    int width_px = 0;
    int height_px = 0;
    std::vector<float> values;  // finite, row by row from the top
};

/// Throws IoError for anything but a picture of one channel of real numbers, all of them finite.
HeightPicture read_height_exr(std::span<const std::byte> bytes, const std::string& file_name);

}  // namespace probebake
