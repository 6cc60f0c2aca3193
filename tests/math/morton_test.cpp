#include "math/morton.h"

#include <gtest/gtest.h>

#include "math/random.h"

namespace probebake {
namespace {

uint64_t encode_bit_by_bit(uint32_t x, uint32_t y, uint32_t z) {
    uint64_t code = 0;
    for (int bit = 0; bit < 16; ++bit) {
        code |= uint64_t{(x >> bit) & 1u} << (3 * bit);
        code |= uint64_t{(y >> bit) & 1u} << (3 * bit + 1);
        code |= uint64_t{(z >> bit) & 1u} << (3 * bit + 2);
    }
    return code;
}

TEST(Morton, AgreesWithBitByBit) {
    RandomStream random(1);
    for (int i = 0; i < 100000; ++i) {
        const auto x = static_cast<uint32_t>(random.below(65536));
        const auto y = static_cast<uint32_t>(random.below(65536));
        const auto z = static_cast<uint32_t>(random.below(65536));
        const uint64_t code = morton_encode(x, y, z);
        ASSERT_EQ(code, encode_bit_by_bit(x, y, z));
        ASSERT_EQ(morton_decode(code), IVec3(x, y, z));
    }
}

TEST(Morton, Corners) {
    EXPECT_EQ(morton_encode(1, 0, 0), 1u);
    EXPECT_EQ(morton_encode(0, 1, 0), 2u);
    EXPECT_EQ(morton_encode(0, 0, 1), 4u);
    EXPECT_EQ(morton_encode(65535, 65535, 65535), (uint64_t{1} << 48) - 1);
}

}  // namespace
}  // namespace probebake
