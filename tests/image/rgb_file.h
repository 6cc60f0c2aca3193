// Reading what other programs wrote.
#pragma once

#include <ImfRgbaFile.h>

#include <string>
#include <vector>

#include "image/image.h"

namespace probebake::test {

/// Any RGB file of OpenEXR, HALF or FLOAT, at HALF precision.
inline Image read_rgb_file(const std::string& path) {
    Imf::RgbaInputFile file(path.c_str());
    const Imath::Box2i window = file.dataWindow();
    Image image(window.max.x + 1, window.max.y + 1);
    std::vector<Imf::Rgba> values(image.pixels().size());
    file.setFrameBuffer(values.data(), 1, static_cast<size_t>(image.width()));
    file.readPixels(0, window.max.y);
    for (size_t i = 0; i < values.size(); ++i) {
        image.pixels()[i] = Rgb(values[i].r, values[i].g, values[i].b);
    }
    return image;
}

}  // namespace probebake::test
