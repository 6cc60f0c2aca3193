#include "scene/heightmap/height_exr.h"

#include <ImfChannelList.h>

#include <cmath>

#include "image/exr_file.h"
#include "scene/picture/picture_file.h"

namespace probebake {

HeightPicture read_height_exr(std::span<const std::byte> bytes, const std::string& file_name) {
    ExrReader reader(bytes, file_name, kMaxPictureSide_px, kMaxPictureSide_px);
    const Imf::ChannelList& channels = reader.header().channels();
    int count = 0;
    for (auto at = channels.begin(); at != channels.end(); ++at) ++count;
    if (count != 1) {
        reader.fail("has " + std::to_string(count) + " channels, expected one of heights");
    }
    HeightPicture heights{.width_px = reader.width(), .height_px = reader.height(), .values = {}};
    heights.values.resize(static_cast<size_t>(heights.width_px) *
                          static_cast<size_t>(heights.height_px));
    const ExrChannel<std::byte> channel{channels.begin().name(), Imf::FLOAT,
                                        reinterpret_cast<std::byte*>(heights.values.data()),
                                        sizeof(float)};
    reader.read({&channel, 1});
    for (size_t i = 0; i < heights.values.size(); ++i) {
        if (!std::isfinite(heights.values[i])) {
            const auto width = static_cast<size_t>(heights.width_px);
            reader.fail("its height at column " + std::to_string(i % width) + ", row " +
                        std::to_string(i / width) + " is not finite");
        }
    }
    return heights;
}

}  // namespace probebake
