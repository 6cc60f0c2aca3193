#include "image/hdr.h"

#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "io/byte_reader.h"

namespace probebake {
namespace {

using Rgbe = std::array<uint8_t, 4>;

constexpr size_t kMaxLine_bytes = 1024;
constexpr int kMaxHeaderLines = 256;

std::string read_line(ByteReader& reader) {
    std::string line;
    for (char c = reader.read<char>("the header"); c != '\n'; c = reader.read<char>("the header")) {
        if (line.size() == kMaxLine_bytes) reader.fail("a line of the header is too long");
        line += c;
    }
    return line;
}

/// The number behind a word of the resolution line; removes both.
int take_number(std::string_view& line, std::string_view word, ByteReader& reader) {
    int number = 0;
    const char* end = line.data() + line.size();
    if (line.substr(0, word.size()) == word) {
        const auto [rest, error] = std::from_chars(line.data() + word.size(), end, number);
        if (error == std::errc() && number > 0) {
            line = {rest, static_cast<size_t>(end - rest)};
            return number;
        }
    }
    reader.fail("expected the resolution as \"-Y height +X width\"");
}

Rgb to_rgb(const Rgbe& pixel) {
    if (pixel[3] == 0) return Rgb(0.0f);
    const float unit = std::ldexp(1.0f, int{pixel[3]} - 136);
    return Rgb(pixel[0], pixel[1], pixel[2]) * unit;
}

/// The rest of a run-length encoded scanline, channel by channel, behind its four bytes of mark.
void read_runs(ByteReader& reader, std::vector<Rgbe>& line) {
    for (size_t channel = 0; channel < 4; ++channel) {
        for (size_t x = 0; x < line.size();) {
            size_t count = reader.read<uint8_t>("a run");
            const bool run = count > 128;
            if (run) count -= 128;
            if (count == 0 || count > line.size() - x) reader.fail("a run has a wrong length");
            const uint8_t value = run ? reader.read<uint8_t>("a run") : uint8_t{0};
            for (size_t i = 0; i < count; ++i) {
                line[x++][channel] = run ? value : reader.read<uint8_t>("a run");
            }
        }
    }
}

void read_scanline(ByteReader& reader, std::vector<Rgbe>& line) {
    const auto first = reader.read<Rgbe>("a scanline");
    const bool encoded =
        line.size() >= 8 && line.size() < 32768 && first[0] == 2 && first[1] == 2 && first[2] < 128;
    if (encoded) {
        if (line.size() != static_cast<size_t>(first[2]) * 256 + first[3]) {
            reader.fail("a scanline has another width than the picture");
        }
        read_runs(reader, line);
        return;
    }
    line[0] = first;
    for (size_t x = 1; x < line.size(); ++x) line[x] = reader.read<Rgbe>("a scanline");
}

}  // namespace

Image decode_hdr(std::span<const std::byte> bytes, const std::string& file, int max_width,
                 int max_height) {
    ByteReader reader(file, bytes);
    const std::string magic = read_line(reader);
    if (magic != "#?RADIANCE" && magic != "#?RGBE") reader.fail("is not a Radiance picture");
    bool known = false;
    int lines = 0;
    for (std::string line = read_line(reader); !line.empty(); line = read_line(reader)) {
        if (line == "FORMAT=32-bit_rle_rgbe") known = true;
        if (++lines == kMaxHeaderLines) reader.fail("the header has too many lines");
    }
    if (!known) reader.fail("expected FORMAT=32-bit_rle_rgbe");
    const std::string resolution = read_line(reader);
    std::string_view rest = resolution;
    const int height = take_number(rest, "-Y ", reader);
    const int width = take_number(rest, " +X ", reader);
    if (width > max_width || height > max_height) {
        reader.fail("is " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels, expected at most " + std::to_string(max_width) + " x " +
                    std::to_string(max_height));
    }
    Image image(width, height);
    std::vector<Rgbe> line(static_cast<size_t>(width));
    for (int y = 0; y < height; ++y) {
        read_scanline(reader, line);
        for (int x = 0; x < width; ++x) image.at(x, y) = to_rgb(line[static_cast<size_t>(x)]);
    }
    return image;
}

}  // namespace probebake
