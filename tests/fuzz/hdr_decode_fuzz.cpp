// decode_hdr on anything: a whole picture of finite values within the limits, or an IoError within
// the file.
#include <cstdlib>

#include "image/hdr.h"
#include "io/io_error.h"

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace probebake;
    constexpr int kMaxWidth = 256;
    constexpr int kMaxHeight = 128;
    try {
        const Image image =
            decode_hdr(std::as_bytes(std::span(data, size)), "fuzz.hdr", kMaxWidth, kMaxHeight);
        require(image.width() >= 1 && image.width() <= kMaxWidth);
        require(image.height() >= 1 && image.height() <= kMaxHeight);
        for (const Rgb& pixel : image.pixels()) {
            require(is_finite(Vec3(pixel)) && pixel.r >= 0.0f && pixel.g >= 0.0f &&
                    pixel.b >= 0.0f);
        }
    } catch (const IoError& error) {
        require(error.offset_bytes().has_value() && *error.offset_bytes() <= size);
    }
    return 0;
}
