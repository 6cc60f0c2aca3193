#include "volume/density_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <utility>

namespace probebake {
namespace {

/// Exact for halves that are finite and not negative, subnormal ones too.
float from_half(uint16_t half) {
    return std::bit_cast<float>(static_cast<uint32_t>(half) << 13) * 0x1.0p112f;
}

/// The half of this value, or 0xFFFF where there is none.
uint16_t to_exact_half(float value) {
    constexpr uint16_t kNone = 0xFFFF;
    if (!(value <= 65504.0f)) return kNone;
    const uint32_t bits = std::bit_cast<uint32_t>(value * 0x1.0p-112f);
    const auto half = static_cast<uint16_t>(bits >> 13);
    return from_half(half) == value ? half : kNone;
}

size_t lattice_index(int x, int y, int z) {
    return static_cast<size_t>((z * DensityGrid::kSide + y) * DensityGrid::kSide + x);
}

struct Findings {
    uint64_t not_finite = 0;
    uint64_t negative = 0;
    size_t first = 0;
};

/// Looks at the lattice points that no other brick counts, so that the sums are counts of voxels.
Findings inspect(std::span<const float> values, bool& constant) {
    Findings found;
    constant = true;
    for (int z = 0; z < DensityGrid::kSide; ++z) {
        for (int y = 0; y < DensityGrid::kSide; ++y) {
            for (int x = 0; x < DensityGrid::kSide; ++x) {
                const size_t at = lattice_index(x, y, z);
                const float value = values[at];
                constant = constant && value == values[0];
                if (value >= 0.0f && std::isfinite(value)) continue;
                constexpr int kOwn = DensityGrid::kBrick;
                if (x == kOwn || y == kOwn || z == kOwn) continue;
                if (found.not_finite + found.negative == 0) found.first = at;
                if (value < 0.0f && std::isfinite(value)) {
                    ++found.negative;
                } else {
                    ++found.not_finite;
                }
            }
        }
    }
    return found;
}

std::string describe(uint64_t not_finite, uint64_t negative, const IVec3& first) {
    return std::to_string(not_finite) + " voxels are NaN or infinite, " + std::to_string(negative) +
           " are negative, the first at [" + std::to_string(first.x) + " " +
           std::to_string(first.y) + " " + std::to_string(first.z) +
           "]; expected finite densities, not negative";
}

}  // namespace

BadDensity::BadDensity(uint64_t not_finite, uint64_t negative, const IVec3& first)
    : std::runtime_error(describe(not_finite, negative, first)),
      not_finite_(not_finite),
      negative_(negative),
      first_(first) {}

void DensityGrid::check_extent(const BuildParams& params) {
    uint64_t count = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const int cells = params.cells[axis];
        if (cells < 1 || cells > kMaxCells) {
            throw std::length_error(std::to_string(cells) + " cells along an axis; expected 1 to " +
                                    std::to_string(kMaxCells));
        }
        count *= static_cast<uint64_t>((cells + kBrick - 1) / kBrick);
    }
    if (count > kMaxBricks) {
        throw std::length_error(std::to_string(count) + " bricks of 8 cells; expected at most " +
                                std::to_string(kMaxBricks));
    }
}

DensityGrid::DensityGrid(const BuildParams& params, const FillBrick& fill)
    : low_(params.low), cells_(params.cells), origin_(params.low), extent_(params.cells) {
    check_extent(params);
    bricks_ = (cells_ + kBrick - 1) / kBrick;
    const auto count = static_cast<size_t>(bricks_.x) * static_cast<size_t>(bricks_.y) *
                       static_cast<size_t>(bricks_.z);
    table_.assign(count, kConstant);
    // A layer of bricks at a time: threads fill in its bricks, then they are laid down in order.
    const auto layer = static_cast<size_t>(bricks_.x) * static_cast<size_t>(bricks_.y);
    struct Filled {
        std::vector<float> values;  // one for a constant brick
        Findings found;
    };
    Findings all;
    IVec3 first(0);
    for (int bz = 0; bz < bricks_.z; ++bz) {
        std::vector<Filled> filled(layer);
        tbb::parallel_for(size_t{0}, layer, [&](size_t i) {
            std::array<float, kBrickValues> values;
            const IVec3 at(static_cast<int>(i) % bricks_.x, static_cast<int>(i) / bricks_.x, bz);
            if (!fill(low_ + at * kBrick, BrickValues(values))) return;
            bool constant = false;
            filled[i].found = inspect(values, constant);
            filled[i].values.assign(values.begin(), constant ? values.begin() + 1 : values.end());
        });
        for (size_t i = 0; i < layer; ++i) {
            Filled& brick = filled[i];
            if (brick.found.not_finite + brick.found.negative > 0) {
                if (all.not_finite + all.negative == 0) {
                    const auto at = static_cast<int>(brick.found.first);
                    first = low_ +
                            IVec3(static_cast<int>(i) % bricks_.x, static_cast<int>(i) / bricks_.x,
                                  bz) *
                                kBrick +
                            IVec3(at % kSide, at / kSide % kSide, at / (kSide * kSide));
                }
                all.not_finite += brick.found.not_finite;
                all.negative += brick.found.negative;
                continue;
            }
            uint32_t& entry = table_[static_cast<size_t>(bz) * layer + i];
            if (brick.values.size() == 1) {
                if (brick.values[0] == 0.0f) continue;
                if (brick.values[0] != constants_.back()) constants_.push_back(brick.values[0]);
                entry = kConstant | static_cast<uint32_t>(constants_.size() - 1);
            } else if (!brick.values.empty()) {
                entry = static_cast<uint32_t>(float_.size() / kBrickValues);
                float_.insert(float_.end(), brick.values.begin(), brick.values.end());
            }
        }
    }
    if (all.not_finite + all.negative > 0) throw BadDensity(all.not_finite, all.negative, first);
    keep_as_half_if_exact();
}

DensityGrid::DensityGrid(Arrays arrays)
    : low_(arrays.low),
      cells_(arrays.cells),
      origin_(arrays.low),
      extent_(arrays.cells),
      table_(std::move(arrays.table)),
      constants_(std::move(arrays.constants)),
      float_(std::move(arrays.floats)),
      half_(std::move(arrays.halves)) {
    const auto require = [](bool fits) {
        if (!fits) throw std::invalid_argument("arrays that do not fit together");
    };
    check_extent({low_, cells_});
    bricks_ = (cells_ + kBrick - 1) / kBrick;
    require(table_.size() == static_cast<size_t>(bricks_.x) * static_cast<size_t>(bricks_.y) *
                                 static_cast<size_t>(bricks_.z));
    require(!constants_.empty() && (float_.empty() || half_.empty()));
    require((float_.size() + half_.size()) % kBrickValues == 0);
    const uint64_t stored = stored_bricks();
    require(std::all_of(table_.begin(), table_.end(), [&](uint32_t e) {
        return (e & kConstant) != 0 ? (e & ~kConstant) < constants_.size() : e < stored;
    }));
    const auto is_density = [](float v) { return v >= 0.0f && std::isfinite(v); };
    require(std::all_of(constants_.begin(), constants_.end(), is_density));
    require(std::all_of(float_.begin(), float_.end(), is_density));
    require(std::all_of(half_.begin(), half_.end(),
                        [&](uint16_t h) { return h < 0x7C00 && is_density(from_half(h)); }));
}

void DensityGrid::keep_as_half_if_exact() {
    std::vector<uint16_t> halves(float_.size());
    for (size_t i = 0; i < float_.size(); ++i) {
        halves[i] = to_exact_half(float_[i]);
        if (halves[i] == 0xFFFF) {
            float_.shrink_to_fit();
            return;
        }
    }
    half_ = std::move(halves);
    float_ = {};
}

float DensityGrid::stored(size_t at) const {
    return half_.empty() ? float_[at] : from_half(half_[at]);
}

double DensityGrid::sample(const Vec3& index) const {
    const Vec3 from = index - origin_;
    // NaN fails; the border belongs to no cell where it is 0 anyway.
    if (!(from.x >= 0.0 && from.y >= 0.0 && from.z >= 0.0 && from.x < extent_.x &&
          from.y < extent_.y && from.z < extent_.z)) {
        return 0.0;
    }
    const IVec3 cell(from);
    const uint32_t brick =
        entry({cell.x >> kBrickLog2, cell.y >> kBrickLog2, cell.z >> kBrickLog2});
    if ((brick & kConstant) != 0) return double{constants_[brick & ~kConstant]};
    const Vec3 f = from - Vec3(cell);
    const IVec3 in(cell.x & (kBrick - 1), cell.y & (kBrick - 1), cell.z & (kBrick - 1));
    const size_t at = brick * kBrickValues + lattice_index(in.x, in.y, in.z);
    constexpr size_t kY = kSide;
    constexpr size_t kZ = size_t{kSide} * kSide;
    const auto along_x = [&](size_t i) {
        const double a = double{stored(i)};
        return a + (double{stored(i + 1)} - a) * f.x;
    };
    const double a0 = along_x(at);
    const double a = a0 + (along_x(at + kY) - a0) * f.y;
    const double b0 = along_x(at + kZ);
    const double b = b0 + (along_x(at + kZ + kY) - b0) * f.y;
    return a + (b - a) * f.z;
}

float DensityGrid::value(const IVec3& lattice) const {
    const IVec3 from = lattice - low_;
    for (int axis = 0; axis < 3; ++axis) {
        if (from[axis] < 0 || from[axis] > cells_[axis]) return 0.0f;
    }
    const IVec3 brick = glm::min(from / kBrick, bricks_ - 1);
    const uint32_t e = entry(brick);
    if ((e & kConstant) != 0) return constants_[e & ~kConstant];
    const IVec3 in = from - brick * kBrick;
    return stored(e * kBrickValues + lattice_index(in.x, in.y, in.z));
}

DensityGrid::Bounds DensityGrid::bounds_in_brick(const IVec3& low, const IVec3& high) const {
    const IVec3 from = low - low_;
    const IVec3 brick = from / kBrick;
    const uint32_t e = entry(brick);
    if ((e & kConstant) != 0) {
        const float constant = constants_[e & ~kConstant];
        return {constant, constant};
    }
    const IVec3 a = from - brick * kBrick;
    const IVec3 b = high - low + a;
    Bounds bounds{std::numeric_limits<float>::infinity(), 0.0f};
    for (int z = a.z; z <= b.z; ++z) {
        for (int y = a.y; y <= b.y; ++y) {
            for (int x = a.x; x <= b.x; ++x) {
                const float v = stored(e * kBrickValues + lattice_index(x, y, z));
                bounds.least = std::min(bounds.least, v);
                bounds.most = std::max(bounds.most, v);
            }
        }
    }
    return bounds;
}

DensityGrid::Bounds DensityGrid::brick_bounds(const IVec3& brick) const {
    const IVec3 low = low_ + brick * kBrick;
    return bounds_in_brick(low, low + kBrick);
}

uint64_t DensityGrid::stored_bricks() const {
    return (float_.size() + half_.size()) / kBrickValues;
}

uint64_t DensityGrid::memory_bytes() const {
    return table_.size() * sizeof(uint32_t) + constants_.size() * sizeof(float) +
           float_.size() * sizeof(float) + half_.size() * sizeof(uint16_t);
}

}  // namespace probebake
