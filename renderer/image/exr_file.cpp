#include "image/exr_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "io/byte_reader.h"

namespace probebake {
namespace {

constexpr int kZipLevel = 4;

/// Large enough for some 50 channels; each of them makes OpenEXR allocate lines of the image.
constexpr size_t kMaxChannelList_bytes = 1024;

class MemoryOutput : public Imf::OStream {
  public:
    MemoryOutput() : Imf::OStream("memory") {}

    void write(const char data[], int size) override {
        const size_t count = static_cast<size_t>(size);
        bytes_.resize(std::max(bytes_.size(), at_ + count));
        std::memcpy(bytes_.data() + at_, data, count);
        at_ += count;
    }
    uint64_t tellp() override { return at_; }
    void seekp(uint64_t position) override { at_ = position; }

    std::vector<std::byte> take() { return std::move(bytes_); }

  private:
    std::vector<std::byte> bytes_;
    uint64_t at_ = 0;
};

Imf::Slice slice_of(const ExrChannel<const std::byte>& channel, int width) {
    // A slice is for reading and writing alike; OutputFile only reads from it.
    return {channel.type, const_cast<char*>(reinterpret_cast<const char*>(channel.first)),
            channel.stride_bytes, channel.stride_bytes * static_cast<size_t>(width)};
}

std::string read_name(ByteReader& reader, const char* what) {
    constexpr size_t kMaxLength = 255;
    std::string name;
    for (char c = reader.read<char>(what); c != '\0'; c = reader.read<char>(what)) {
        if (name.size() == kMaxLength) reader.fail(std::string(what) + " is too long");
        name += c;
    }
    return name;
}

/// Walks the header without believing any size in it; returns width and height.
std::array<int, 2> check_header(ByteReader reader, int max_width, int max_height) {
    constexpr uint32_t kMagic = 20000630;
    constexpr uint32_t kVersion = 2;
    constexpr uint32_t kLongNames = 0x400;
    if (reader.read<uint32_t>("the magic number") != kMagic) reader.fail("is not an EXR file");
    if ((reader.read<uint32_t>("the version") & ~kLongNames) != kVersion) {
        reader.fail("is not a single-part file of scanlines, version 2");
    }
    std::array<int, 2> size{};
    while (true) {
        const std::string name = read_name(reader, "the name of an attribute");
        if (name.empty()) break;
        read_name(reader, "the type of an attribute");
        const auto bytes = reader.read<uint32_t>("the size of an attribute");
        if (name == "channels" && bytes > kMaxChannelList_bytes)
            reader.fail("has too many channels");
        ByteReader value = reader.part(bytes, "an attribute");
        if (name == "dataWindow") {
            const auto window = value.read<std::array<int32_t, 4>>("the data window");
            size = {window[2], window[3]};
            if (window[0] != 0 || window[1] != 0 || size[0] < 0 || size[0] >= max_width ||
                size[1] < 0 || size[1] >= max_height) {
                value.fail("the data window is (" + std::to_string(window[0]) + " " +
                           std::to_string(window[1]) + ") - (" + std::to_string(window[2]) + " " +
                           std::to_string(window[3]) + "), expected to begin at (0 0), at most " +
                           std::to_string(max_width) + " wide and " + std::to_string(max_height) +
                           " high");
            }
            size = {size[0] + 1, size[1] + 1};
        }
    }
    if (size[0] == 0) reader.fail("has no data window");
    return size;
}

}  // namespace

std::vector<std::byte> encode_exr(Imf::Header header,
                                  std::span<const ExrChannel<const std::byte>> channels) {
    const int width = header.dataWindow().max.x + 1;
    const int height = header.dataWindow().max.y + 1;
    header.compression() = Imf::ZIP_COMPRESSION;
    header.zipCompressionLevel() = kZipLevel;
    Imf::FrameBuffer frame;
    for (const auto& channel : channels) {
        header.channels().insert(channel.name, Imf::Channel(channel.type));
        frame.insert(channel.name, slice_of(channel, width));
    }
    MemoryOutput stream;
    {
        Imf::OutputFile file(stream, header, 0);
        file.setFrameBuffer(frame);
        file.writePixels(height);
    }
    return stream.take();
}

class ExrReader::Stream : public Imf::IStream {
  public:
    Stream(std::span<const std::byte> bytes, const std::string& file)
        : Imf::IStream(file.c_str()), bytes_(bytes) {}

    bool read(char data[], int size) override {
        const size_t count = static_cast<size_t>(size);
        if (size < 0 || at_ > bytes_.size() || count > bytes_.size() - at_) {
            throw IoError(fileName(), at_, "ends too early");
        }
        std::memcpy(data, bytes_.data() + at_, count);
        at_ += count;
        return at_ < bytes_.size();
    }
    uint64_t tellg() override { return at_; }
    void seekg(uint64_t position) override { at_ = position; }

  private:
    std::span<const std::byte> bytes_;
    uint64_t at_ = 0;
};

ExrReader::ExrReader(std::span<const std::byte> bytes, std::string file, int max_width,
                     int max_height)
    : file_(std::move(file)) {
    const auto size = check_header(ByteReader(file_, bytes), max_width, max_height);
    width_ = size[0];
    height_ = size[1];
    stream_ = std::make_unique<Stream>(bytes, file_);
    try {
        input_ = std::make_unique<Imf::InputFile>(*stream_, 0);
    } catch (const IoError&) {
        throw;
    } catch (const std::exception& error) {
        fail(error.what());
    }
    const Imath::Box2i& window = header().dataWindow();
    if (window.max.x + 1 != width_ || window.max.y + 1 != height_) fail("has two data windows");
}

ExrReader::~ExrReader() = default;

void ExrReader::read(std::span<const ExrChannel<std::byte>> channels) {
    Imf::FrameBuffer frame;
    for (const auto& channel : channels) {
        const Imf::Channel* stored = header().channels().findChannel(channel.name);
        const std::string name = "channel " + std::string(channel.name);
        if (stored == nullptr) fail("has no " + name);
        if (stored->xSampling != 1 || stored->ySampling != 1) fail(name + " is subsampled");
        if ((stored->type == Imf::UINT) != (channel.type == Imf::UINT)) {
            fail(name +
                 (channel.type == Imf::UINT ? " is not UINT" : " is neither HALF nor FLOAT"));
        }
        const ExrChannel<const std::byte> view{channel.name, channel.type, channel.first,
                                               channel.stride_bytes};
        frame.insert(channel.name, slice_of(view, width_));
    }
    try {
        input_->setFrameBuffer(frame);
        input_->readPixels(0, height_ - 1);
    } catch (const IoError&) {
        throw;
    } catch (const std::exception& error) {
        fail(error.what());
    }
}

}  // namespace probebake
