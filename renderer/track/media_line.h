// The line of a world-space ray through Media: what trackers see of them.
//
// Pieces: octree leaves of grids, stretches of fog over which its density halves or doubles, whole
// boxes of homogeneous media; where media overlap, the pieces between all their borders, with sums
// of their bounds. In a gray line (N = 1) extinction stands in for scattering and nothing is
// absorbed: albedos, which may be coloured, weigh the path at every collision.
//
// Bounds are exact; a look-up beyond them by more than rounding is counted (unbounded()), one
// within is brought back to them.
#pragma once

#include <array>
#include <memory>

#include "track/track.h"
#include "volume/media.h"

namespace probebake {

/// The pieces of one medium along a ray, in density.
class DensityCursor {
  public:
    DensityCursor(const Medium& medium, const Ray& ray_m, const TRange& range);

    bool next(DensitySegment& segment);
    double density(double t) const {
        return kind_ == Kind::kGrid ? grid_->sample(origin_ + direction_ * t) : simple_density(t);
    }
    double emission_scale(double t) const;

  private:
    enum class Kind : uint8_t { kGrid, kFog, kHomogeneous };

    bool next_fog(DensitySegment& segment);
    /// Of fog and homogeneous media.
    double simple_density(double t) const;

    Kind kind_ = Kind::kHomogeneous;
    const DensityGrid* grid_ = nullptr;
    const DensityGrid* emission_ = nullptr;
    OctreeWalk walk_;
    Vec3 origin_{0.0};  // index space of a grid; y above the base, in scale heights, of fog
    Vec3 direction_{0.0};
    double t_ = 0.0;
    double end_ = 0.0;
};

/// Densities of all media at a place.
using Densities = std::array<double, kMaxMedia>;

template <int N>
class MediaLine {
  public:
    static constexpr int kChannels = N;
    static constexpr bool kGray = N == 1;

    MediaLine(const Media& media, const Ray& ray_m, const TRange& range)
        : media_(media.all()), count_(media_.size()), t_(range.begin), end_(range.end) {
        for (size_t k = 0; k < count_; ++k) {
            std::construct_at(&slots_[k].part, media_[k], ray_m, range);
            if (count_ > 1) there_[k] = part(k).cursor.next(pieces_[k]);
        }
    }

    bool next(Segment<N>& segment) {
        if (count_ == 1) {
            if (!part(0).cursor.next(pieces_[0])) return false;
            segment.t0 = pieces_[0].t0;
            segment.t1 = pieces_[0].t1;
            segment.least = part(0).unit * pieces_[0].least;
            segment.most = part(0).unit * pieces_[0].most;
            return true;
        }
        return next_of_several(segment);
    }

    Coefficients<N> at(double t) {
        if (count_ == 1) return part(0).unit * look_up(0, t);
        Coefficients<N> sum;
        for (size_t k = 0; k < count_; ++k) {
            if (active(k)) {
                sum += part(k).unit * look_up(k, t);
            } else {
                densities_[k] = 0.0;
            }
        }
        return sum;
    }

    /// W·m⁻²·sr⁻¹ per metre at the last look-up.
    Spectrum<3> emitted_per_m(double t) const {
        Spectrum<3> sum;
        for (size_t k = 0; k < count_; ++k) {
            if (!(densities_[k] > 0.0)) continue;
            sum += media_[k].unit.absorption * media_[k].source *
                   (densities_[k] * part(k).cursor.emission_scale(t));
        }
        return sum;
    }

    /// What a collision was with: the control is the minorants, the residual what is above them.
    Densities collided(const FlightEnd& end, bool decomposes) const {
        Densities out{};
        for (size_t k = 0; k < count_; ++k) {
            if (!active(k)) continue;
            if (end.control) {
                out[k] = pieces_[k].least;
            } else {
                out[k] = decomposes ? densities_[k] - pieces_[k].least : densities_[k];
            }
        }
        return out;
    }

    uint64_t unbounded() const { return unbounded_; }

  private:
    struct Part {
        Part(const Medium& medium, const Ray& ray_m, const TRange& range)
            : unit(unit_of(medium)), cursor(medium, ray_m, range) {}

        Coefficients<N> unit;  // at density 1
        DensityCursor cursor;
    };

    static Coefficients<N> unit_of(const Medium& medium) {
        if constexpr (kGray) {
            return {Spectrum<1>(0.0), Spectrum<1>(medium.unit.extinction()[1])};
        } else {
            return medium.unit;
        }
    }

    /// The density of a medium, within the bounds of its piece.
    double look_up(size_t k, double t) {
        const DensitySegment& piece = pieces_[k];
        const double exact = part(k).cursor.density(t);
        const double d = std::clamp(exact, piece.least, piece.most);
        densities_[k] = d;
        // Leaves end at rounded t: a look-up may lie a rounding error beside its leaf.
        if (exact != d && std::abs(exact - d) > 1e-6 * (1.0 + piece.most)) ++unbounded_;
        return d;
    }
    Part& part(size_t k) { return slots_[k].part; }
    const Part& part(size_t k) const { return slots_[k].part; }
    bool active(size_t k) const { return count_ == 1 || (there_[k] && pieces_[k].t0 <= from_); }

    bool next_of_several(Segment<N>& segment) {
        double to = end_;
        bool any = false;
        for (size_t k = 0; k < count_; ++k) {
            while (there_[k] && !(pieces_[k].t1 > t_)) there_[k] = part(k).cursor.next(pieces_[k]);
            if (!there_[k]) continue;
            any = true;
            to = std::min(to, pieces_[k].t0 > t_ ? pieces_[k].t0 : pieces_[k].t1);
        }
        if (!any || !(t_ < end_)) return false;
        segment = {};
        segment.t0 = t_;
        segment.t1 = to;
        from_ = t_;
        for (size_t k = 0; k < count_; ++k) {
            if (!active(k)) continue;
            segment.least += part(k).unit * pieces_[k].least;
            segment.most += part(k).unit * pieces_[k].most;
        }
        t_ = to;
        return true;
    }

    const std::vector<Medium>& media_;
    size_t count_;
    // Only those of the media that are there are made, and nothing is zeroed: a line is made for
    // every flight.
    union Slot {
        Slot() {}  // NOLINT(modernize-use-equals-default): that would be deleted
        Part part;
    };
    static_assert(std::is_trivially_destructible_v<Part>);
    std::array<Slot, kMaxMedia> slots_;
    std::array<DensitySegment, kMaxMedia> pieces_;
    std::array<bool, kMaxMedia> there_{};  // whether the piece is one
    Densities densities_{};                // of the last look-up
    double t_;
    double from_ = 0.0;  // where the current piece of several begins
    double end_;
    uint64_t unbounded_ = 0;
};

}  // namespace probebake
