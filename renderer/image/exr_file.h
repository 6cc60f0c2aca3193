// Any channels as a single-part scanline EXR file in memory; what exr.h's files have in common.
//
// Channels are strided views of the caller's memory, so that interleaved pixels need no copies.
// Untrusted bytes are safe to read: the header is walked with bounds, and the size of the image and
// of the channel list limited, before OpenEXR or the caller allocates anything by it.
#pragma once

#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfPixelType.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/io_error.h"

namespace probebake {

/// Where a channel's value of the first pixel lies in memory, and the bytes from there to the next
/// pixel's. The type is the file's when writing, memory's when reading.
template <class Byte>
struct ExrChannel {
    const char* name;
    Imf::PixelType type;
    Byte* first;
    size_t stride_bytes;
};

/// Size, compression and attributes are the header's; its list of channels is filled here.
std::vector<std::byte> encode_exr(Imf::Header header,
                                  std::span<const ExrChannel<const std::byte>> channels);

class ExrReader {
  public:
    /// Checks and opens; the bytes must outlive the reader. Throws IoError with `file` where they
    /// are no single-part scanline EXR image of at most max_width × max_height, its data window
    /// starting at (0, 0).
    ExrReader(std::span<const std::byte> bytes, std::string file, int max_width, int max_height);
    ~ExrReader();
    ExrReader(const ExrReader&) = delete;
    ExrReader& operator=(const ExrReader&) = delete;

    int width() const { return width_; }
    int height() const { return height_; }
    const Imf::Header& header() const { return input_->header(); }
    /// Reads every pixel; converts between HALF and FLOAT. Throws IoError for damaged data and
    /// where a channel is missing, subsampled, or a count where a real number is wanted or vice
    /// versa.
    void read(std::span<const ExrChannel<std::byte>> channels);

    [[noreturn]] void fail(const std::string& problem) const { throw IoError(file_, problem); }

  private:
    class Stream;

    std::string file_;
    int width_ = 0;
    int height_ = 0;
    std::unique_ptr<Stream> stream_;
    std::unique_ptr<Imf::InputFile> input_;
};

}  // namespace probebake
