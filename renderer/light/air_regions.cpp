#include "light/air_regions.h"

#include <algorithm>
#include <bit>

namespace probebake {
namespace {

/// The runs of `within` that hold any bit of `bits`.
uint32_t spread(uint32_t bits, uint32_t within) {
    for (;;) {
        const uint32_t wider = (bits | bits << 1 | bits >> 1) & within;
        if (wider == bits) return bits;
        bits = wider;
    }
}

}  // namespace

AirRegions::AirRegions(const FaceBlock& block)
    : corner_(block.corner()),
      side_(block.edge() + 2),
      free_(static_cast<size_t>(side_ * side_), 0) {
    for (int z = -1; z <= block.edge(); ++z) {
        for (int y = -1; y <= block.edge(); ++y) {
            uint32_t& row = free_[index(y, z)];
            for (int x = -1; x <= block.edge(); ++x) {
                if (!block.solid({x, y, z})) row |= 1u << (x + 1);
            }
        }
    }
    for (size_t row = 0; row < free_.size(); ++row) {
        while (free_[row] != 0) {
            const std::vector<uint32_t> rows = take_region(row);
            ++count_;
            const bool only = count_ == 1 && std::all_of(free_.begin(), free_.end(),
                                                         [](uint32_t rest) { return rest == 0; });
            if (!only) number(rows);
        }
    }
}

std::vector<uint32_t> AirRegions::take_region(size_t row) {
    std::vector<uint32_t> rows(free_.size(), 0);
    const auto enter = [&](size_t to, uint32_t bits) {
        const uint32_t reached = spread(bits & free_[to], free_[to]);
        if (reached == 0) return;
        free_[to] &= ~reached;
        rows[to] |= reached;
        open_.push_back(to);
    };
    const auto side = static_cast<size_t>(side_);
    enter(row, free_[row] & (~free_[row] + 1));
    while (!open_.empty()) {
        const size_t at = open_.back();
        open_.pop_back();
        const uint32_t bits = rows[at];
        if (at % side > 0) enter(at - 1, bits);
        if (at % side + 1 < side) enter(at + 1, bits);
        if (at >= side) enter(at - side, bits);
        if (at + side < rows.size()) enter(at + side, bits);
    }
    return rows;
}

void AirRegions::number(const std::vector<uint32_t>& rows) {
    regions_.resize(free_.size() * static_cast<size_t>(side_), 0);
    for (size_t row = 0; row < rows.size(); ++row) {
        for (uint32_t rest = rows[row]; rest != 0; rest &= rest - 1) {
            regions_[row * static_cast<size_t>(side_) +
                     static_cast<size_t>(std::countr_zero(rest))] = static_cast<uint16_t>(count_);
        }
    }
}

}  // namespace probebake
