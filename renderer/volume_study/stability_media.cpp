// The cases of media: flights and transmittances.
#include <cmath>
#include <limits>

#include "math/random.h"
#include "track/bound_guard.h"
#include "track/choice.h"
#include "track/delta.h"
#include "track/media_line.h"
#include "track/spectral.h"
#include "track/spectral_mis.h"
#include "track/transmittance.h"
#include "volume/phase.h"
#include "volume_study/stability.h"
#include "volume_study/stability_clouds.h"

namespace probebake::volume_study {
namespace {

using Cases = std::vector<StabilityCase>;
using Gray = TrackTraits<1, false, false>;

constexpr int kFlights = 20'000;

/// One homogeneous leaf of length 1 whose majorant is `bound` times its extinction.
class Slab {
  public:
    Slab(double tau, double bound) : tau_(tau), bound_(bound) {}
    bool next(Segment<1>& segment) {
        segment = {0.0, 1.0, {}, {Spectrum<1>(0.0), Spectrum<1>(bound_ * tau_)}};
        return pieces_-- > 0;
    }
    Coefficients<1> at(double /*t*/) { return {Spectrum<1>(0.0), Spectrum<1>(tau_)}; }
    /// For fly_guarded.
    double excess() const { return 1.0 / bound_; }

  private:
    double tau_;
    double bound_;
    int pieces_ = 1;
};

/// A leaf without an end in which nothing is ever met.
struct Endless {
    int pieces = 1;
    bool next(Segment<1>& segment) {
        segment = {0.0, 1e30, {}, {Spectrum<1>(0.0), Spectrum<1>(1.0)}};
        return pieces-- > 0;
    }
    Coefficients<1> at(double /*t*/) { return {}; }
};

Moments escape_of(const Media& media, const Ray& ray, TrackCount& count) {
    Moments escaped;
    RandomStream random(1);
    for (int i = 0; i < kFlights; ++i) {
        MediaLine<1> line(media, ray, {});
        Spectrum<1> w(1.0);
        const FlightEnd end = DeltaTracker::fly<Gray>(line, w, random, count, CollectNothing());
        escaped.add(end.event == Event::kEscape ? 1.0 : 0.0);
    }
    return escaped;
}

void empty_leaves(Cases& all) {
    const std::string name = "majorant 0";
    const auto grid = lattice(64, [](const IVec3& p) { return p.x < 8 ? 0.25f : 0.0f; });
    const Media media(
        {{.name = "corner", .scattering_per_m = Rgb(1.0f), .shape = GridShape{grid, {}, nullptr}}});
    const Ray ray{{-5.0, 33.0, 33.0}, {1, 0, 0}};
    TrackCount count;
    const Moments escaped = escape_of(media, ray, count);
    all.push_back(unbiased(name, "escape through empty leaves", escaped,
                           std::exp(-media.optical_depth(ray, {})[0])));
    all.push_back(at_most(name, "faults", static_cast<double>(count.faults), 0.0));
}

void bad_densities(Cases& all) {
    const std::string name = "NaN, infinite, negative density";
    std::string found = "accepted";
    try {
        lattice(16, [](const IVec3& p) {
            if (p == IVec3(3, 4, 5)) return std::numeric_limits<float>::quiet_NaN();
            if (p == IVec3(6, 4, 5)) return std::numeric_limits<float>::infinity();
            return p == IVec3(7, 4, 5) ? -1.0f : 1.0f;
        });
    } catch (const BadDensity& error) {
        found = std::to_string(error.not_finite()) + " not finite, " +
                std::to_string(error.negative()) + " negative, first at " +
                std::to_string(error.first().x) + " " + std::to_string(error.first().y) + " " +
                std::to_string(error.first().z);
    }
    const std::string expected = "2 not finite, 1 negative, first at 3 4 5";
    all.push_back({.name = name,
                   .checked = "refused at load, with counts",
                   .value = found,
                   .bound = expected,
                   .pass = found == expected});
    int refused = 0;
    constexpr double kBad[] = {std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity(), -1.0};
    for (const double bad : kBad) {
        for (int field = 0; field < 4; ++field) {
            MediumSpec spec{
                .name = "bad", .absorption_per_m = Rgb(1.0f), .scattering_per_m = Rgb(1.0f)};
            const auto value = static_cast<float>(bad);
            if (field == 0) spec.absorption_per_m.g = value;
            if (field == 1) spec.scattering_per_m.b = value;
            if (field == 2) spec.emission.r = value;
            if (field == 3) spec.g = bad;
            try {
                check_medium(spec);
            } catch (const std::invalid_argument&) {
                ++refused;
            }
        }
    }
    all.push_back(
        at_least("NaN, infinite, negative coefficients and g", "refused, of 12", refused, 12));
    Endless line;
    RandomStream random(4);
    TrackCount count;
    Spectrum<1> w(1.0);
    DeltaTracker::fly<Gray>(line, w, random, count, CollectNothing());
    all.push_back(at_least("a flight without end", "ended and counted as faults",
                           static_cast<double>(count.faults), 1.0));
}

/// Cosines at the ends of both arguments, and what the textbook's form makes of small g.
void phase_ends(Cases& all) {
    double most = 0.0;
    for (const double g : {-0.999999, -1e-6, -1e-30, 0.0, 1e-30, 1e-6, 0.999999}) {
        for (const double u : {0.0, 0x1.0p-53, 0.5, 1.0 - 0x1.0p-53}) {
            const double cosine = sample_henyey_greenstein(g, u);
            most = std::max(most, std::isfinite(cosine) ? std::abs(cosine) : 2.0);
        }
    }
    all.push_back(at_most("phase function at its ends", "largest cosine", most, 1.0));
    const auto textbook = [](float g, float u) {
        const float s = (1.0f - g * g) / (1.0f - g + 2.0f * g * u);
        return (1.0f + g * g - s * s) / (2.0f * g);
    };
    double off = 0.0;
    for (int i = 0; i < 100; ++i) {
        const float u = static_cast<float>(i) / 100.0f;
        off = std::max(
            off, std::abs(double{textbook(1e-6f, u)} - sample_henyey_greenstein(1e-6, double{u})));
    }
    const std::string guard = "without the guard: ";
    all.push_back(at_least("phase function, g = 0.000001",
                           guard + "cosine off by, textbook's form in float", off, 0.03));
    all.push_back(at_least("phase function, g = 0.000000", guard + "textbook's form is NaN",
                           std::isnan(textbook(0.0f, 0.25f)) ? 1.0 : 0.0, 1.0));
}

void numbers(Cases& all) {
    // b·t of a flight in one leaf: steps that do not advance t.
    for (const double bt : {1e6, 1e8}) {
        RandomStream random(5);
        uint64_t lost = 0;
        uint64_t lost_in_float = 0;
        for (int i = 0; i < 100'000; ++i) {
            const double t = 1.0 - 0.5 * random.uniform();
            const double dt = exponential(random, bt);
            lost += t + dt == t ? 1 : 0;
            const auto narrow = static_cast<float>(t);
            lost_in_float += narrow + static_cast<float>(dt) == narrow ? 1 : 0;
        }
        const std::string name = "b·t = " + std::string(bt > 1e7 ? "1e8" : "1e6");
        all.push_back(at_most(name, "share of steps lost, t in double",
                              static_cast<double>(lost) / 1e5, 1e-4));
        all.push_back(at_least(name, "without the guard: lost with t in float",
                               static_cast<double>(lost_in_float) / 1e5, 0.02));
    }
    struct Last {
        double uniform() const { return 1.0 - 0x1.0p-53; }
    } last;
    all.push_back(
        at_most("uniform next to 1", "length of the longest step", exponential(last, 1.0), 37.0));

    for (const double g : {-0.9999, -1e-6, 0.0, 1e-6, 0.9999}) {
        Moments cosine;
        RandomStream random(6);
        for (int i = 0; i < kFlights; ++i)
            cosine.add(sample_henyey_greenstein(g, random.uniform()));
        all.push_back(
            unbiased("phase function, g = " + study::decimals(g, 6), "mean cosine", cosine, g));
    }

    phase_ends(all);

    RandomStream random(7);
    Spectrum<3> w({1.0, 0.0, 0.0});
    const Spectrum<3> green({0.0, 1.0, 0.0});
    choose_event<Scheme::kHistoryAverage, Termination::kFull>(w, Spectrum<3>(), green,
                                                              Spectrum<3>(), 1.0, 1.0, random);
    all.push_back(at_most("Σ P = 0", "weight left of the path", w.max_abs(), 0.0));

    double sum = 0.0;
    float narrow = 0.0f;
    for (int i = 0; i < 10'000'000; ++i) {
        sum += double{0.1f};
        narrow += 0.1f;
    }
    const double exact = 1e7 * double{0.1f};
    all.push_back(at_most("sum of 1e7 samples", "relative error in double",
                          std::abs(sum / exact - 1.0), 1e-9));
    all.push_back(at_least("sum of 1e7 samples", "without the guard: in float",
                           std::abs(double{narrow} / exact - 1.0), 1e-5));
}

template <class Tracker>
std::array<Moments, 3> escape_per_channel(const Media& media, const Ray& ray) {
    std::array<Moments, 3> moments;
    RandomStream random(8);
    TrackCount count;
    for (int i = 0; i < kFlights; ++i) {
        MediaLine<3> line(media, ray, {});
        Spectrum<3> w(1.0);
        const FlightEnd end = Tracker::template fly<TrackTraits<3, true, false>>(
            line, w, random, count, CollectNothing());
        for (int c = 0; c < 3; ++c) {
            moments[static_cast<size_t>(c)].add(end.event == Event::kEscape ? w[c] : 0.0);
        }
    }
    return moments;
}

void stiff_spectra(Cases& all) {
    const Media media({{.name = "stiff",
                        .absorption_per_m = Rgb(0.01f, 1.0f, 100.0f),
                        .shape = HomogeneousShape{Box{{0, 0, 0}, {1, 1, 1}}}}});
    const Ray ray{{-1, 0.5, 0.5}, {1, 0, 0}};
    const std::string name = "extinction 1 : 1e2 : 1e4";
    const auto mis = escape_per_channel<SpectralMis>(media, ray);
    all.push_back(unbiased(name, "spectral MIS, R", mis[0], std::exp(-double{0.01f})));
    all.push_back(unbiased(name, "spectral MIS, G", mis[1], std::exp(-1.0)));
    const auto plain = escape_per_channel<SpectralTracker<Scheme::kAverage>>(media, ray);
    const auto most = escape_per_channel<SpectralTracker<Scheme::kMax>>(media, ray);
    const std::string choice = "without the choice: plain ";
    all.push_back(at_most(name, choice + "average, R (truth 0.99)", plain[0].mean(), 0.5));
    all.push_back(at_most(name, choice + "average, its variance", plain[0].variance(), 0.01));
    all.push_back(at_most(name, choice + "maximum, R (truth 0.99)", most[0].mean(), 0.5));
    const MediaFacts facts = facts_of(media);
    all.push_back(
        at_least(name, "ratio that the choice sees (MIS above 8)", facts.extinction_ratio, 9000.0));
}

void bounds(Cases& all) {
    for (const double f : {0.5, 0.8}) {
        constexpr double kTau = 1.0;
        Moments weighted;
        Moments ratio;
        RandomStream random(9);
        TrackCount count;
        for (int i = 0; i < 20 * kFlights; ++i) {
            Slab a(kTau, f);
            Spectrum<1> w(1.0);
            const FlightEnd end = WeightedDelta::fly<Gray>(a, w, random, count, CollectNothing());
            weighted.add(end.event == Event::kEscape ? w[0] : 0.0);
            Slab b(kTau, f);
            ratio.add(RatioTracking<false>::transmittance<Gray>(b, random, count)[0]);
        }
        const std::string name = "majorant " + study::decimals(f, 1) + " μ, τ = 1";
        const double square = std::exp(-2.0 * kTau);
        const auto off_by = [&](const Moments& m, double relative) {
            return std::abs(m.variance() / square / relative - 1.0);
        };
        all.push_back(unbiased(name, "weighted delta, transmittance", weighted, std::exp(-kTau)));
        all.push_back(at_most(name, "weighted delta, variance against e^(τ(2−f)/f) − 1",
                              off_by(weighted, std::expm1(kTau * (2.0 - f) / f)), 0.1));
        all.push_back(unbiased(name, "ratio, transmittance", ratio, std::exp(-kTau)));
        all.push_back(at_most(name, "ratio, variance against e^(τ/f) − 1",
                              off_by(ratio, std::expm1(kTau / f)), 0.1));
    }
    BoundGuard guard;
    Moments escaped;
    RandomStream random(10);
    for (int i = 0; i < kFlights; ++i) {
        const FlightEnd end = fly_guarded(
            guard, [](double factor) { return Slab(2.0, 0.2 * factor); },
            [&](Slab& line) {
                Spectrum<1> w(1.0);
                TrackCount count;
                return DeltaTracker::fly<Gray>(line, w, random, count, CollectNothing());
            });
        escaped.add(end.event == Event::kEscape ? 1.0 : 0.0);
    }
    all.push_back(unbiased("majorant 0.2 μ, raised", "escape", escaped, std::exp(-2.0)));
    all.push_back(at_least("majorant 0.2 μ, raised", "flights flown again",
                           static_cast<double>(guard.raised), 1.0));
}

void transmittances(Cases& all) {
    const Media cloud({{.name = "cloud", .scattering_per_m = Rgb(1.0f), .shape = lumps()}},
                      {.max_depth = 1, .threshold = 0.1});
    const Ray ray{{0.3, -20, 0.2}, {0, 1, 0}};
    const Ray fringe{{5.0, -20, 0.2}, {0, 1, 0}};  // where little of the majorant is there
    struct Ratios {
        Moments moments;
        double largest = 0.0;  // absolute
    };
    const auto ratios = [&](double between) {
        Ratios out;
        RandomStream random(11);
        TrackCount count;
        for (int i = 0; i < kFlights; ++i) {
            MediaLine<1> line(cloud, fringe, {});
            const double t = ResidualRatio::transmittance<Gray>(line, random, count, between)[0];
            out.moments.add(t);
            out.largest = std::max(out.largest, std::abs(t));
        }
        return out;
    };
    const Ratios minorant = ratios(0.0);
    const Ratios midpoint = ratios(0.5);
    const std::string residual = "residual ratio";
    all.push_back(unbiased(residual, "T with the minorant", minorant.moments,
                           std::exp(-cloud.optical_depth(fringe, {})[0])));
    all.push_back(at_most(residual, "largest absolute T with the minorant", minorant.largest, 1.0));
    all.push_back(at_least(residual, "without the guard: largest absolute T with the midpoint",
                           midpoint.largest, 2.0));
    all.push_back(at_least(residual, "without the guard: variance, midpoint over minorant",
                           midpoint.moments.variance() / minorant.moments.variance(), 10.0));

    const auto shell = lattice(64, [](const IVec3& p) {
        return std::abs(glm::length(Vec3(p) - 32.0) - 20.0) < 1.0 ? 1e4f : 1.0f;
    });
    const auto lookups = [&](int depth) {
        const Media media({{.name = "shell",
                            .scattering_per_m = Rgb(1e-3f),
                            .shape = GridShape{shell, {}, nullptr}}},
                          {.max_depth = depth, .threshold = 0.5});
        TrackCount count;
        escape_of(media, {{33.0, 32.0, 32.0}, {0, 1, 0}}, count);
        return static_cast<double>(count.lookups) / kFlights;
    };
    all.push_back(
        at_most("thin shell, contrast 1e4", "look-ups per flight, split", lookups(8), 5.0));
    all.push_back(
        at_least("thin shell, contrast 1e4", "without the guard: in one leaf", lookups(1), 100.0));

    const Media thick({{.name = "thick", .scattering_per_m = Rgb(4000.0f), .shape = lumps()}},
                      {.max_depth = 9, .threshold = 20.0});
    const double tau = thick.optical_depth(ray, {})[0];
    TrackCount plain;
    TrackCount roulette;
    TrackCount delta;
    RandomStream random(12);
    constexpr int kRays = 200;
    for (int i = 0; i < kRays; ++i) {
        MediaLine<1> a(thick, ray, {});
        RatioTracking<false>::transmittance<Gray>(a, random, plain);
        MediaLine<1> b(thick, ray, {});
        RatioTracking<true>::transmittance<Gray>(b, random, roulette);
        MediaLine<1> c(thick, ray, {});
        DeltaVisibility::transmittance<Gray>(c, random, delta);
    }
    all.push_back(at_least("τ = 1e4 towards the sun", "optical depth", tau, 1e4));
    all.push_back(at_most("τ = 1e4 towards the sun", "look-ups per ray, ratio with roulette",
                          static_cast<double>(roulette.lookups) / kRays, 50.0));
    all.push_back(at_most("τ = 1e4 towards the sun", "look-ups per ray, delta 0 or 1",
                          static_cast<double>(delta.lookups) / kRays, 50.0));
    all.push_back(at_least("τ = 1e4 towards the sun", "without the guard: look-ups per ray",
                           static_cast<double>(plain.lookups) / kRays, 100.0));
}

}  // namespace

std::vector<StabilityCase> media_cases() {
    Cases all;
    empty_leaves(all);
    bad_densities(all);
    numbers(all);
    stiff_spectra(all);
    bounds(all);
    transmittances(all);
    for (StabilityCase& one : furnace_cases()) all.push_back(std::move(one));
    return all;
}

}  // namespace probebake::volume_study
