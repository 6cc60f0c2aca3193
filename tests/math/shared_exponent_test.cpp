#include "math/shared_exponent.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "math/random.h"

namespace probebake {
namespace {

TEST(SharedExponent, ErrorStaysBelowHalfAStepOfTheLargestComponent) {
    RandomStream random(7);
    for (int i = 0; i < 200000; ++i) {
        const double magnitude = std::exp2(random.uniform() * 30.0 - 14.0);
        const Rgb in(static_cast<float>(random.uniform() * magnitude),
                     static_cast<float>(random.uniform() * magnitude),
                     static_cast<float>(random.uniform() * magnitude));
        const float largest = std::max({in.r, in.g, in.b});
        if (largest > kPackedRgbMax) continue;
        const Rgb out = unpack_rgb(pack_rgb(in));
        for (int c = 0; c < 3; ++c) {
            ASSERT_LE(std::abs(out[c] - in[c]), std::max(largest / 512.0f, 0x1p-25f)) << in[c];
        }
    }
}

TEST(SharedExponent, PowersOfTwoAndZeroAreExact) {
    EXPECT_EQ(pack_rgb(Rgb(0.0f)), 0u);
    for (int e = -15; e <= 15; ++e) {
        const float x = std::ldexp(1.0f, e);
        EXPECT_EQ(unpack_rgb(pack_rgb(Rgb(x, x / 2, 0.0f))), Rgb(x, x / 2, 0.0f)) << e;
    }
    EXPECT_EQ(unpack_rgb(pack_rgb(Rgb(kPackedRgbMax))), Rgb(kPackedRgbMax));
}

TEST(SharedExponent, PackingAnUnpackedColourIsTheIdentity) {
    RandomStream random(3);
    for (int i = 0; i < 100000; ++i) {
        const Rgb in(static_cast<float>(random.uniform()), static_cast<float>(random.uniform()),
                     static_cast<float>(random.uniform()));
        const PackedRgb packed = pack_rgb(in);
        ASSERT_EQ(pack_rgb(unpack_rgb(packed)), packed);
    }
}

}  // namespace
}  // namespace probebake
