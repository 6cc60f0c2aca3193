#include "image/hdr.h"

#include <gtest/gtest.h>

#include <string>

#include "io/io_error.h"
#include "math/random.h"

namespace probebake {
namespace {

const std::string kHeader = "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n";

Image decode(const std::string& text) {
    return decode_hdr(std::as_bytes(std::span(text)), "sky.hdr", 64, 32);
}

/// Two rows of eight pixels: the first run-length encoded, the second plain.
std::string small_picture() {
    std::string text = kHeader + "-Y 2 +X 8\n";
    text += std::string("\x02\x02\x00\x08", 4);
    text += std::string("\x88\x80", 2);                              // red: a run of 8
    text += std::string("\x08\x00\x01\x02\x03\x04\x05\x06\x07", 9);  // green: eight values
    text += std::string("\x84\x40\x04\x01\x02\x03\x04", 7);          // blue: both
    text += std::string("\x87\x81\x01\x00", 4);                      // exponents; the last is 0
    for (int x = 0; x < 8; ++x) text += std::string("\x10\x20\x40\x88", 4);
    return text;
}

TEST(Hdr, ReadsRunLengthEncodedAndPlainRows) {
    const Image image = decode(small_picture());
    ASSERT_EQ(image.width(), 8);
    ASSERT_EQ(image.height(), 2);
    // Exponent 129: mantissas / 128. Exponent 136: mantissas themselves.
    EXPECT_EQ(image.at(0, 0), Rgb(1.0f, 0.0f, 0.5f));
    EXPECT_EQ(image.at(5, 0), Rgb(1.0f, 5.0f / 128.0f, 2.0f / 128.0f));
    EXPECT_EQ(image.at(7, 0), Rgb(0.0f));
    EXPECT_EQ(image.at(3, 1), Rgb(16.0f, 32.0f, 64.0f));
}

TEST(Hdr, EveryTruncationIsRefusedWithItsOffset) {
    const std::string whole = small_picture();
    for (size_t length = 0; length < whole.size(); ++length) {
        try {
            decode(whole.substr(0, length));
            ADD_FAILURE() << length;
        } catch (const IoError& error) {
            EXPECT_TRUE(error.offset_bytes().has_value());
            EXPECT_LE(*error.offset_bytes(), length);
        }
    }
}

TEST(Hdr, RandomDamageNeverCrashes) {
    RandomStream random(11);
    int refused = 0;
    for (int i = 0; i < 20000; ++i) {
        std::string text = small_picture();
        for (uint64_t n = 1 + random.below(4); n > 0; --n) {
            text[random.below(text.size())] = static_cast<char>(random.below(256));
        }
        try {
            decode(text);
        } catch (const IoError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 5000);
}

TEST(Hdr, RefusesWhatItDoesNotRead) {
    EXPECT_THROW(decode("#?RADIANCE\n\n-Y 2 +X 8\n"), IoError);        // no format
    EXPECT_THROW(decode(kHeader + "+X 8 -Y 2\n"), IoError);            // turned
    EXPECT_THROW(decode(kHeader + "-Y 2 +X 99999999999\n"), IoError);  // too large
    EXPECT_THROW(decode(kHeader + "-Y 2 +X 65\n"), IoError);           // too wide
    EXPECT_THROW(decode(kHeader + "-Y 0 +X 8\n"), IoError);
    std::string zero_run = kHeader + "-Y 1 +X 8\n" + std::string("\x02\x02\x00\x08", 4);
    zero_run += std::string(1000, '\0');
    EXPECT_THROW(decode(zero_run), IoError);
}

}  // namespace
}  // namespace probebake
