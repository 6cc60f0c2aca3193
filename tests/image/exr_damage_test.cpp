#include <ImfChromaticitiesAttribute.h>
#include <ImfEnvmapAttribute.h>
#include <ImfIntAttribute.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <cstring>

#include "image/cubemaps.h"
#include "image/exr.h"
#include "image/exr_attributes.h"
#include "image/exr_file.h"

namespace probebake {
namespace {

using Bytes = std::vector<std::byte>;

std::string message_of(const Bytes& bytes) {
    try {
        decode_cubemap(bytes, "cube.exr");
    } catch (const IoError& error) {
        EXPECT_EQ(error.file(), "cube.exr");
        return error.what();
    }
    return "no error";
}

void expect_message(const Bytes& bytes, const std::string& part) {
    const std::string message = message_of(bytes);
    EXPECT_NE(message.find(part), std::string::npos) << message << "\nexpected: " << part;
}

/// A file of one grey value with these channels.
Bytes grey_file(const Imf::Header& header, const std::string& names,
                Imf::PixelType type = Imf::FLOAT, float value = 0.5f) {
    const size_t count = static_cast<size_t>(header.dataWindow().max.x + 1) *
                         static_cast<size_t>(header.dataWindow().max.y + 1);
    const std::vector<float> values(count, value);
    const std::byte* first = std::as_bytes(std::span(values)).data();
    std::vector<std::string> texts;
    for (const char name : names) texts.emplace_back(1, name);
    std::vector<ExrChannel<const std::byte>> channels(names.size());
    for (size_t i = 0; i < channels.size(); ++i) {
        channels[i] = {texts[i].c_str(), type, first, sizeof(float)};
    }
    return encode_exr(header, channels);
}

Imf::Header cube_header(int n = 4) { return make_cube_header(n, {}); }

size_t find_text(const Bytes& bytes, const std::string& text) {
    const auto as_byte = std::as_bytes(std::span(text));
    return static_cast<size_t>(
        std::search(bytes.begin(), bytes.end(), as_byte.begin(), as_byte.end()) - bytes.begin());
}

/// Overwrites 4 bytes at a distance behind a text.
Bytes patched(Bytes bytes, const std::string& text, size_t distance, uint32_t value) {
    const size_t at = find_text(bytes, text) + text.size() + distance;
    EXPECT_LE(at + sizeof(value), bytes.size());
    std::memcpy(bytes.data() + at, &value, sizeof(value));
    return bytes;
}

TEST(ExrReading, AcceptsWhatOthersMayWrite) {
    const auto decoded = decode_cubemap(grey_file(cube_header(), "RGBAZ"), "cube.exr");
    EXPECT_TRUE(decoded.is_float);
    EXPECT_EQ(decoded.cubemap.at({CubeFace::kNegZ, 3, 3}), Rgb(0.5f));
    Imf::Header bare(4, 24);
    bare.insert("envmap", Imf::EnvmapAttribute(Imf::ENVMAP_CUBE));
    EXPECT_EQ(decode_cubemap(grey_file(bare, "RGB"), "cube.exr").attributes, ProbeAttributes());
}

TEST(ExrReading, SaysWhatIsWrong) {
    expect_message({}, "cube.exr: offset 0: the magic number needs 4 bytes, 0 are left");
    expect_message(Bytes(4000, std::byte{0x2a}), "is not an EXR file");
    expect_message(grey_file(cube_header(), "RB"), "has no channel G");
    expect_message(grey_file(cube_header(), "RGB", Imf::UINT),
                   "channel R is neither HALF nor FLOAT");
    expect_message(grey_file(cube_header(), "RGB", Imf::FLOAT, std::nanf("")),
                   "face +X, pixel (0, 0), channel R: the value is nan");
    expect_message(grey_file(cube_header(), "RGB", Imf::FLOAT, -1.0f), "the value is -1.0");

    Imf::Header wrong_shape(4, 23);
    wrong_shape.insert("envmap", Imf::EnvmapAttribute(Imf::ENVMAP_CUBE));
    expect_message(grey_file(wrong_shape, "RGB"),
                   "is 4 x 23, expected six square faces in a column");
    Imf::Header no_envmap(4, 24);
    expect_message(grey_file(no_envmap, "RGB"), "is not a cube-face environment map");
    no_envmap.insert("envmap", Imf::EnvmapAttribute(Imf::ENVMAP_LATLONG));
    expect_message(grey_file(no_envmap, "RGB"), "is not a cube-face environment map");
    Imf::Header text_envmap(4, 24);
    text_envmap.insert("envmap", Imf::StringAttribute("cube"));
    expect_message(grey_file(text_envmap, "RGB"),
                   "attribute envmap has type string, expected envmap");

    Imf::Header primaries = cube_header();
    Imf::Chromaticities wide;
    wide.green = {0.17f, 0.797f};
    primaries.insert("chromaticities", Imf::ChromaticitiesAttribute(wide));
    expect_message(grey_file(primaries, "RGB"), "primaries other than Rec.709");

    Imf::Header wrong_type(4, 24);
    wrong_type.insert("envmap", Imf::EnvmapAttribute(Imf::ENVMAP_CUBE));
    wrong_type.insert("probe:near", Imf::IntAttribute(3));
    expect_message(grey_file(wrong_type, "RGB"),
                   "attribute probe:near has type int, expected double");
    Imf::Header bad_seed(4, 24);
    bad_seed.insert("envmap", Imf::EnvmapAttribute(Imf::ENVMAP_CUBE));
    for (const char* seed : {"", "x", "-1", "1 2", "18446744073709551616"}) {
        bad_seed.insert("probe:seed", Imf::StringAttribute(seed));
        expect_message(grey_file(bad_seed, "RGB"), "attribute probe:seed is \"");
    }
}

TEST(ExrReading, RefusesOtherKindsOfFiles) {
    const Bytes good = encode_cubemap(test::direction_cubemap(4), {}).bytes;
    for (const uint32_t flags : {0x200u, 0x800u, 0x1000u, 0x1u, 0x10000u}) {
        Bytes other = good;
        const uint32_t version = (2u | flags) == 3u ? 3u : 2u | flags;
        std::memcpy(other.data() + 4, &version, sizeof(version));
        expect_message(other, "is not a single-part file of scanlines, version 2");
    }
}

TEST(ExrReading, HostileSizesAreRefusedBeforeTheyAreAllocated) {
    const Bytes good = encode_cubemap(test::direction_cubemap(4), {}).bytes;
    // Behind a name and its type's name with their zeros comes the size of an attribute.
    const std::string owner("owner\0string\0", 13);
    const std::string window("dataWindow\0box2i\0", 17);
    const std::string channels("channels\0chlist\0", 16);
    expect_message(patched(good, owner, 0, 0x7fffffffu), "an attribute needs 2147483647 bytes");
    expect_message(patched(good, owner, 0, 0xffffffffu), "an attribute needs 4294967295 bytes");
    expect_message(patched(good, channels, 0, 0x10000u), "has too many channels");
    expect_message(patched(good, window, 0, 4u), "the data window needs 16 bytes");
    for (const size_t place : {size_t{12}, size_t{16}}) {
        for (const uint32_t value : {0x7fffffffu, 0xffffffffu, 0x80000000u, 24576u}) {
            expect_message(patched(good, window, place, value), "the data window is (0 0) - (");
        }
    }
    expect_message(patched(good, window, 4, 1u), "expected to begin at (0 0)");
}

TEST(ExrReading, EveryTruncationIsFound) {
    for (const int n : {1, 4, 64}) {
        const Bytes good = encode_cubemap(test::random_cubemap(n, 9), {}).bytes;
        const size_t step = n == 64 ? 997 : 1;
        for (size_t size = 0; size < good.size(); size += step) {
            const auto part = std::span(good).first(size);
            ASSERT_THROW(decode_cubemap(part, "cube.exr"), IoError)
                << n << ": " << size << " bytes";
        }
        ASSERT_NO_THROW(decode_cubemap(good, "cube.exr"));
    }
}

TEST(ExrReading, ADamagedByteIsFoundOrLeavesThePixelsAlone) {
    // Smooth, so that every block is compressed and has zlib's checksum.
    const Cubemap cubemap = test::direction_cubemap(16);
    const Bytes good = encode_cubemap(cubemap, {}).bytes;
    const Cubemap expected = rounded_to_file(cubemap);
    size_t found = 0;
    size_t tried = 0;
    for (size_t at = 0; at < good.size(); ++at) {
        for (const unsigned flip : {0x01u, 0x80u, 0xffu}) {
            Bytes bad = good;
            bad[at] ^= static_cast<std::byte>(flip);
            ++tried;
            try {
                ASSERT_TRUE(decode_cubemap(bad, "cube.exr").cubemap == expected) << "byte " << at;
            } catch (const IoError&) {
                ++found;
            }
        }
    }
    EXPECT_GT(found, tried * 8 / 10) << tried;
}

TEST(ExrReading, RandomDamageIsAnErrorOrAnImage) {
    const Bytes good = encode_cubemap(test::random_cubemap(16, 9), {}).bytes;
    RandomStream random(99);
    for (int i = 0; i < 3000; ++i) {
        Bytes bad = good;
        for (uint64_t count = 1 + random.below(8); count > 0; --count) {
            // Mostly in the header and in the table of blocks, where the sizes are.
            const size_t where = random.below(random.below(4) == 0 ? bad.size() : 900);
            bad[where] = static_cast<std::byte>(random.next() & 0xffu);
        }
        try {
            EXPECT_EQ(decode_cubemap(bad, "cube.exr").cubemap.face_size(), 16);
        } catch (const IoError&) {
        }
    }
}

}  // namespace
}  // namespace probebake
