// One-dimensional media with an exact solution: coefficients on a lattice, linear in between.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "math/random.h"
#include "track/track.h"

namespace probebake::test {

inline constexpr int kLattice = 64;  // cells

struct LatticeMedium {
    std::string name;
    double length = 1.0;
    std::vector<Coefficients<3>> points;  // kLattice + 1

    Coefficients<3> at(double t) const {
        const double x = std::clamp(t / length, 0.0, 1.0) * kLattice;
        const int i = std::min(static_cast<int>(x), kLattice - 1);
        const double f = x - i;
        Coefficients<3> sum = points[static_cast<size_t>(i)] * (1.0 - f);
        sum += points[static_cast<size_t>(i) + 1] * f;
        return sum;
    }
};

/// The line through a LatticeMedium in 2^(depth − 1) equal leaves with exact bounds. The planted
/// bias multiplies what look-ups give; `bound` multiplies the majorant.
class LatticeLine {
  public:
    static constexpr int kChannels = 3;

    LatticeLine(const LatticeMedium& medium, int depth, double planted = 1.0, double bound = 1.0)
        : medium_(&medium), leaves_(1 << (depth - 1)), planted_(planted), bound_(bound) {}

    bool next(Segment<3>& segment) {
        if (leaf_ == leaves_) return false;
        const int cells = kLattice / leaves_;
        const double edge = medium_->length / leaves_;
        segment = {leaf_ * edge, (leaf_ + 1) * edge, medium_->points[at(leaf_ * cells)],
                   medium_->points[at(leaf_ * cells)]};
        for (int i = leaf_ * cells + 1; i <= (leaf_ + 1) * cells; ++i) {
            const Coefficients<3>& p = medium_->points[at(i)];
            for (int c = 0; c < 3; ++c) {
                const auto widen = [&](double& least, double& most, double value) {
                    least = std::min(least, value);
                    most = std::max(most, value);
                };
                widen(segment.least.absorption[c], segment.most.absorption[c], p.absorption[c]);
                widen(segment.least.scattering[c], segment.most.scattering[c], p.scattering[c]);
            }
        }
        segment.most = segment.most * bound_;
        ++leaf_;
        return true;
    }
    Coefficients<3> at(double t) const { return medium_->at(t) * planted_; }

  private:
    static size_t at(int i) { return static_cast<size_t>(i); }

    const LatticeMedium* medium_;
    int leaves_;
    int leaf_ = 0;
    double planted_;
    double bound_;
};

/// Integrals of weight over all flights, per channel, by quadrature.
struct LineSolution {
    Spectrum<3> escape;
    Spectrum<3> absorb;
    Spectrum<3> scatter;
    Spectrum<3> scatter_at;  // × t / length
};

inline LineSolution solve(const LatticeMedium& medium) {
    constexpr int kSteps = 400;  // per cell; midpoint rule, τ exact
    LineSolution out;
    Spectrum<3> tau;
    const double dt = medium.length / (kLattice * kSteps);
    for (int i = 0; i < kLattice * kSteps; ++i) {
        const double t = (i + 0.5) * dt;
        const Coefficients<3> mu = medium.at(t);
        const Spectrum<3> step = mu.extinction() * dt;
        // ∫ T over the step, exact for constant μ.
        Spectrum<3> mean = exp(tau * -1.0);
        for (int c = 0; c < 3; ++c) {
            if (step[c] > 0.0) mean[c] *= -std::expm1(-step[c]) / step[c];
        }
        out.absorb += mean * mu.absorption * dt;
        out.scatter += mean * mu.scattering * dt;
        out.scatter_at += mean * mu.scattering * (dt * t / medium.length);
        tau += step;
    }
    out.escape = exp(tau * -1.0);
    return out;
}

/// Absorption and scattering densities along x in [0, 1], and their colours at density 1.
struct LatticeRecipe {
    std::string name;
    double length;
    std::function<double(double)> absorb;
    std::function<double(double)> scatter;
    Spectrum<3> absorb_color{1.0};
    Spectrum<3> scatter_color{1.0};
};

inline LatticeMedium make_medium(const LatticeRecipe& recipe) {
    LatticeMedium medium{recipe.name, recipe.length, {}};
    for (int i = 0; i <= kLattice; ++i) {
        const double x = static_cast<double>(i) / kLattice;
        medium.points.push_back(
            {recipe.absorb_color * recipe.absorb(x), recipe.scatter_color * recipe.scatter(x)});
    }
    return medium;
}

inline std::vector<LatticeMedium> seventeen_media() {
    const auto constant = [](double v) { return [v](double) { return v; }; };
    const auto noise = [](uint64_t seed, double mean) {
        return [=](double x) {
            RandomStream random(
                random_key({seed, static_cast<uint64_t>(std::llround(x * kLattice))}));
            return 2.0 * mean * random.uniform();
        };
    };
    const auto bump = [](double at, double width, double height) {
        return [=](double x) { return height * std::exp(-(x - at) * (x - at) / (width * width)); };
    };
    const Spectrum<3> mild({0.9, 1.0, 1.1});
    const Spectrum<3> tint({1.2, 1.0, 0.7});
    const std::vector<LatticeRecipe> recipes = {
        {"constant", 1.0, constant(0.4), constant(1.0), mild, mild},
        {"ramp up", 1.0, [](double x) { return x; }, [](double x) { return 2.0 * x; }, mild, tint},
        {"ramp down", 2.0, constant(0.2), [](double x) { return 1.5 * (1 - x); }, tint, mild},
        {"triangle", 1.0, [](double x) { return 1.0 - std::abs(2 * x - 1); },
         [](double x) { return 3.0 * (1.0 - std::abs(2 * x - 1)); }, mild, mild},
        {"bump", 1.0, bump(0.5, 0.1, 2.0), bump(0.5, 0.1, 10.0), tint, mild},
        {"two bumps", 1.0, bump(0.8, 0.1, 3.0), bump(0.2, 0.1, 5.0), mild, tint},
        {"step", 1.0, constant(0.3), [](double x) { return x < 0.5 ? 0.1 : 4.0; }, mild, mild},
        {"slab in vacuum", 1.0, constant(0.0),
         [](double x) { return x > 0.45 && x < 0.55 ? 12.0 : 0.0; }, mild, mild},
        {"noise", 1.0, noise(1, 0.5), noise(2, 2.0), mild, tint},
        {"exponential", 3.0, constant(0.05), [](double x) { return 2 * std::exp(-5 * x); }, mild,
         mild},
        {"thick noise", 1.0, noise(3, 4.0), noise(4, 16.0), mild, mild},
        {"gap", 1.0, constant(0.0), [](double x) { return std::abs(x - 0.5) < 0.3 ? 0.0 : 3.0; },
         mild, tint},
        {"albedo 1, 0.5:1:1.4", 1.0, constant(0.0), noise(5, 3.0), mild,
         Spectrum<3>({0.5, 1.0, 1.4})},
        {"1:2:4", 1.0, noise(6, 0.3), noise(7, 1.0), Spectrum<3>({1.0, 2.0, 4.0}),
         Spectrum<3>({1.0, 2.0, 4.0})},
        {"absorbs where it does not scatter", 1.0, [](double x) { return 3.0 * (1 - x); },
         [](double x) { return 3.0 * x; }, tint, mild},
        {"only absorbs", 1.0, noise(8, 1.0), constant(0.0), tint, mild},
        {"shell", 1.0, constant(0.001),
         [](double x) { return std::abs(x - 0.5) < 0.01 ? 60.0 : 0.01; }, mild, mild},
    };
    std::vector<LatticeMedium> media;
    media.reserve(recipes.size());
    for (const LatticeRecipe& recipe : recipes) media.push_back(make_medium(recipe));
    return media;
}

}  // namespace probebake::test
