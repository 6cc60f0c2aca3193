#include "track/bound_guard.h"

#include <gtest/gtest.h>

#include "math/estimate.h"
#include "track/delta.h"
#include "track/lattice_line.h"

namespace probebake {
namespace {

using test::LatticeMedium;

/// A line whose guessed majorant is a share of the right one.
class GuessedLine : public test::LatticeLine {
  public:
    GuessedLine(const LatticeMedium& medium, double guess)
        : test::LatticeLine(medium, 1, 1.0, guess) {}
    bool next(Segment<3>& s) {
        const bool there = test::LatticeLine::next(s);
        if (there) bound_ = s.most.extinction()[1];
        return there;
    }
    Coefficients<3> at(double t) {
        const Coefficients<3> mu = test::LatticeLine::at(t);
        excess_ = std::max(excess_, mu.extinction()[1] / bound_);
        return mu;
    }
    double excess() const { return excess_; }

  private:
    double bound_ = 0.0;
    double excess_ = 0.0;
};

double z_of_escape(bool guarded, BoundGuard& guard) {
    const LatticeMedium medium = test::seventeen_media()[4];  // a bump
    const double exact = test::solve(medium).escape[1];
    Moments escaped;
    RandomStream random(1);
    for (int i = 0; i < 40000; ++i) {
        const auto fly = [&](GuessedLine& line) {
            ChannelLine<GuessedLine> one(line, 1);
            Spectrum<1> w(1.0);
            TrackCount count;
            return DeltaTracker::fly<TrackTraits<1, true, false>>(one, w, random, count,
                                                                  CollectNothing());
        };
        const auto make = [&](double factor) { return GuessedLine(medium, 0.2 * factor); };
        GuessedLine plain = make(1.0);
        const FlightEnd end = guarded ? fly_guarded(guard, make, fly) : fly(plain);
        escaped.add(end.event == Event::kEscape ? 1.0 : 0.0);
    }
    return (escaped.mean() - exact) / std::sqrt(escaped.variance() / 40000.0);
}

TEST(BoundGuard, RaisesABoundUntilItBounds) {
    BoundGuard guard;
    EXPECT_LT(std::abs(z_of_escape(true, guard)), 4.0);
    EXPECT_GT(guard.raised, 0u);
    EXPECT_LT(guard.raised, 100u);
    EXPECT_GT(guard.factor, 4.0);
    EXPECT_LT(guard.factor, 7.0);
}

TEST(BoundGuard, WithoutItDeltaTrackingIsBiased) {
    BoundGuard unused;
    EXPECT_GT(std::abs(z_of_escape(false, unused)), 10.0);
}

}  // namespace
}  // namespace probebake
