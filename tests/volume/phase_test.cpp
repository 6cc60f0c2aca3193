#include "volume/phase.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "math/random.h"

namespace probebake {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Phase, IsADensityWhoseMeanCosineIsG) {
    for (const double g : {-0.99, -0.5, -1e-7, 0.0, 1e-12, 1e-6, 1e-3, 0.3, 0.85, 0.99}) {
        constexpr int kSteps = 400000;
        double total = 0.0;
        double cosine = 0.0;
        for (int i = 0; i < kSteps; ++i) {
            const double c = -1.0 + 2.0 * (i + 0.5) / kSteps;
            const double p = henyey_greenstein(g, c) * 2.0 * kPi * 2.0 / kSteps;
            total += p;
            cosine += p * c;
        }
        EXPECT_NEAR(total, 1.0, 5e-4) << g;
        EXPECT_NEAR(cosine, g, 5e-4) << g;
    }
}

TEST(Phase, SampledCosinesInvertTheDistribution) {
    for (const double g : {-0.95, -1e-9, 0.0, 1e-16, 1e-9, 1e-6, 1e-4, 0.5, 0.999999}) {
        for (int i = 0; i < 1000; ++i) {
            const double u = i / 1000.0;
            const double c = sample_henyey_greenstein(g, u);
            ASSERT_GE(c, -1.0);
            ASSERT_LE(c, 1.0);
            // The distribution function, from its closed form where that is sound.
            if (std::abs(g) < 1e-5) {
                EXPECT_NEAR(c, 2.0 * u - 1.0, 2e-5);
            } else if (std::abs(g) < 0.99) {
                const double f = (1.0 - g * g) / (2.0 * g) *
                                 (1.0 / std::sqrt(1.0 + g * g - 2.0 * g * c) - 1.0 / (1.0 + g));
                EXPECT_NEAR(f, u, 1e-9 / std::abs(g) * 1e-3 + 1e-9) << g;
            }
        }
        EXPECT_NEAR(sample_henyey_greenstein(g, 0.0), -1.0, 1e-9);
    }
}

TEST(Phase, AroundGivesUnitVectorsAtTheCosine) {
    RandomStream random(1);
    for (int i = 0; i < 10000; ++i) {
        Vec3 axis(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
        if (i == 0) axis = {0, 0, -1};
        if (i == 1) axis = {0, 0, 1};
        axis = glm::normalize(axis);
        const double cosine = i < 4 ? 1.0 - 2.0 * (i & 1) : 2.0 * random.uniform() - 1.0;
        const Vec3 d = around(axis, cosine, random.uniform());
        EXPECT_NEAR(glm::length(d), 1.0, 1e-14);
        EXPECT_NEAR(glm::dot(d, axis), cosine, 1e-12);
    }
}

}  // namespace
}  // namespace probebake
