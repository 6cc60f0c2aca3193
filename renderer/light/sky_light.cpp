#include "light/sky_light.h"

#include <algorithm>
#include <numbers>

namespace probebake {
namespace {

constexpr double kPi = std::numbers::pi;
/// Directions around the equator into which a picture is divided at least; 8 per cell.
constexpr int kColumns = 1024;
/// Of a smooth sky's cell, per side.
constexpr int kCellSamples = 4;

double energy(const Vec3& color) { return color.r + color.g + color.b; }

/// The cells stand in Morton order.
size_t cell_index(int column, int row) {
    size_t index = 0;
    for (unsigned bit = 0; bit < 6; ++bit) {
        index |= ((static_cast<size_t>(column) >> bit) & 1u) << (2 * bit);
        index |= ((static_cast<size_t>(row) >> bit) & 1u) << (2 * bit + 1);
    }
    return index;
}

/// Column and row of a Morton code.
Vec2 deinterleave(uint64_t code) {
    unsigned column = 0;
    unsigned row = 0;
    for (unsigned bit = 0; bit < 10; ++bit) {
        column |= static_cast<unsigned>((code >> (2 * bit)) & 1u) << bit;
        row |= static_cast<unsigned>((code >> (2 * bit + 1)) & 1u) << bit;
    }
    return {column, row};
}

/// The point of the unit square at a share of the way along the Morton curve: the strata that share
/// a cell are apart within it, too.
Vec2 morton_point(double along, RandomStream& random) {
    constexpr int kBits = 10;  // of each coordinate; below them it is random
    const auto code = static_cast<uint64_t>(std::clamp(along, 0.0, 1.0 - 0x1.0p-53) *
                                            static_cast<double>(1u << (2 * kBits)));
    const double u = random.uniform();
    const double v = random.uniform();
    return (deinterleave(code) + Vec2(u, v)) / static_cast<double>(1u << kBits);
}

using Cells = std::array<std::vector<Vec3>, kFaceCount>;

Cells smooth_cells(const Sky& sky) {
    Cells cells;
    const double measure = kPi / (SkyLight::kCells * kCellSamples * kCellSamples);
    for (const CubeFace face : kCubeFaces) {
        std::vector<Vec3>& out = cells[static_cast<size_t>(face)];
        out.assign(SkyLight::kCells, Vec3(0.0));
        constexpr int kSide = SkyLight::kGrid * kCellSamples;
        for (int y = 0; y < kSide; ++y) {
            for (int x = 0; x < kSide; ++x) {
                const Vec3 direction =
                    cosine_direction(face, {(x + 0.5) / kSide, (y + 0.5) / kSide});
                out[cell_index(x / kCellSamples, y / kCellSamples)] +=
                    Vec3(sky.radiance(direction)) * measure;
            }
        }
    }
    return cells;
}

/// Every texel's energy in the cells that its parts lie in.
Cells picture_cells(const Sky& sky) {
    Cells cells;
    for (auto& out : cells) out.assign(SkyLight::kCells, Vec3(0.0));
    const int parts = (kColumns + sky.texels() - 1) / sky.texels();
    const int width = sky.texels() * parts;
    const int height = width / 2;
    std::array<double, kFaceCount> measured{};
    for (int y = 0; y < height; ++y) {
        const double low = kPi * (y + 1.0) / height;
        const double high = kPi * y / height;
        const double solid_angle = (std::cos(high) - std::cos(low)) * 2.0 * kPi / width;
        for (int x = 0; x < width; ++x) {
            const Vec3 direction = equirect_direction({(x + 0.5) / width, (y + 0.5) / height});
            const Vec3 radiance(sky.radiance(direction));
            for (const CubeFace face : kCubeFaces) {
                const double sign = index_of(face) % 2 == 0 ? 1.0 : -1.0;
                const double cosine = sign * direction[axis_of(face)];
                if (!(cosine > 0.0)) continue;
                const Vec2 at = cosine_square(face, direction) * double{SkyLight::kGrid};
                const auto cell = [](double u) {
                    return std::clamp(static_cast<int>(u), 0, SkyLight::kGrid - 1);
                };
                cells[static_cast<size_t>(face)][cell_index(cell(at.x), cell(at.y))] +=
                    radiance * (cosine * solid_angle);
                measured[static_cast<size_t>(face)] += cosine * solid_angle;
            }
        }
    }
    for (size_t f = 0; f < kFaceCount; ++f) {
        for (Vec3& cell : cells[f]) cell *= kPi / measured[f];  // a constant picture is exact
    }
    return cells;
}

}  // namespace

SkyLight::SkyLight(const Sky& sky, int strata) : strata_(strata), black_(sky.black()) {
    if (black_) return;
    const Cells cells = sky.texels() > 0 ? picture_cells(sky) : smooth_cells(sky);
    black_ = true;
    for (size_t f = 0; f < kFaceCount; ++f) {
        cut(faces_[f], cells[f]);
        if (energy(faces_[f].total) > 0.0) black_ = false;
    }
}

void SkyLight::cut(Hemisphere& hemisphere, const std::vector<Vec3>& cells) const {
    double sum = 0.0;
    for (const Vec3& cell : cells) {
        sum += energy(cell);
        hemisphere.total += cell;
        hemisphere.cumulative.push_back(sum);
    }
    hemisphere.weights.assign(static_cast<size_t>(strata_), Vec3(0.0));
    if (!(sum > 0.0)) return;
    double begin = 0.0;  // of the cell, in strata
    for (size_t c = 0; c < cells.size(); ++c) {
        const double end = hemisphere.cumulative[c] / sum * strata_;
        const double width = end - begin;
        if (width > 0.0) {
            const int last = std::min(strata_ - 1, static_cast<int>(end));
            for (int s = static_cast<int>(begin); s <= last; ++s) {
                const double part = std::min(end, s + 1.0) - std::max(begin, double(s));
                if (part > 0.0) {
                    hemisphere.weights[static_cast<size_t>(s)] += cells[c] * (part / width);
                }
            }
        }
        begin = end;
    }
}

Vec3 SkyLight::direction(CubeFace face, int stratum, RandomStream& random) const {
    const std::vector<double>& cumulative = at(face).cumulative;
    const double wanted = (stratum + random.uniform()) / strata_ * cumulative.back();
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end(), wanted);
    const auto cell =
        static_cast<size_t>(std::min(found, std::prev(cumulative.end())) - cumulative.begin());
    const double before = cell > 0 ? cumulative[cell - 1] : 0.0;
    const double along = (wanted - before) / (cumulative[cell] - before);
    return cosine_direction(face,
                            (deinterleave(cell) + morton_point(along, random)) / double{kGrid});
}

Vec3 cosine_direction(CubeFace face, const Vec2& square) {
    const Vec2 at = square * 2.0 - Vec2(1.0);
    Vec2 disc(0.0);
    if (at != Vec2(0.0)) {
        const bool wide = std::abs(at.x) > std::abs(at.y);
        const double radius = wide ? at.x : at.y;
        const double angle =
            wide ? kPi / 4.0 * (at.y / at.x) : kPi / 2.0 - kPi / 4.0 * (at.x / at.y);
        disc = radius * Vec2(std::cos(angle), std::sin(angle));
    }
    const int axis = axis_of(face);
    const double sign = index_of(face) % 2 == 0 ? 1.0 : -1.0;
    Vec3 direction;
    // At least a little above the face, so that a ray leaves it.
    direction[axis] = sign * std::sqrt(std::max(1e-12, 1.0 - glm::dot(disc, disc)));
    direction[(axis + 1) % 3] = disc.x;
    direction[(axis + 2) % 3] = disc.y;
    return direction / glm::length(direction);
}

Vec2 cosine_square(CubeFace face, const Vec3& direction) {
    const int axis = axis_of(face);
    const Vec2 disc{direction[(axis + 1) % 3], direction[(axis + 2) % 3]};
    const double radius = glm::length(disc);
    if (!(radius > 0.0)) return Vec2(0.5);
    double angle = std::atan2(disc.y, disc.x);
    if (angle < -kPi / 4.0) angle += 2.0 * kPi;
    Vec2 at;
    if (angle < kPi / 4.0) {
        at = {radius, angle * radius / (kPi / 4.0)};
    } else if (angle < 3.0 * kPi / 4.0) {
        at = {-(angle - kPi / 2.0) * radius / (kPi / 4.0), radius};
    } else if (angle < 5.0 * kPi / 4.0) {
        at = {-radius, -(angle - kPi) * radius / (kPi / 4.0)};
    } else {
        at = {(angle - 3.0 * kPi / 2.0) * radius / (kPi / 4.0), -radius};
    }
    return at * 0.5 + Vec2(0.5);
}

}  // namespace probebake
