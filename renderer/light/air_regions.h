// AirRegions: which empty voxels of a block are joined by a path through empty voxels.
//
// The block is taken with the layer of voxels around it; what is joined only by a longer way around
// counts as two regions. Whoever is in a closed room is in another region than what is outside.
#pragma once

#include <vector>

#include "light/face_block.h"

namespace probebake {

class AirRegions {
  public:
    explicit AirRegions(const FaceBlock& block);

    int count() const { return count_; }
    /// Of an empty voxel of the block or the layer, by its place in the world: 0 to count() − 1.
    /// Where there are several regions, −1 for a voxel.
    int of(const IVec3& voxel) const {
        const IVec3 at = voxel - corner_;
        if (count_ == 1) return 0;
        return regions_[index(at.y, at.z) * static_cast<size_t>(side_) +
                        static_cast<size_t>(at.x + 1)] -
               1;
    }

  private:
    /// Of a row of voxels along x; in a row bit x + 1 stands for the voxel x.
    size_t index(int y, int z) const { return static_cast<size_t>((z + 1) * side_ + y + 1); }
    /// Takes the region that holds a row's lowest free voxel out of free_; returns its rows.
    std::vector<uint32_t> take_region(size_t row);
    void number(const std::vector<uint32_t>& rows);

    IVec3 corner_;
    int side_;
    int count_ = 0;
    std::vector<uint32_t> free_;     // empty voxels that are in no region yet, by rows
    std::vector<uint16_t> regions_;  // numbers from 1, by voxels; empty where there is one region
    std::vector<size_t> open_;
};

}  // namespace probebake
