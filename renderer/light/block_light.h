// The light that falls on the faces of one FaceBlock (lighting.h says how).
#pragma once

#include <array>
#include <vector>

#include "light/face_block.h"
#include "light/lighting.h"
#include "light/sky_light.h"

namespace probebake {

/// Irradiance, W·m⁻², per voxel of the block and face; 0 where the face is not exposed.
using FaceIrradiance = std::vector<std::array<Vec3, kFaceCount>>;

class BlockLight {
  public:
    struct Source {
        const VoxelTree& tree;
        const std::optional<Sun>& sun;
        const SkyLight& sky;
        const LightingParams& params;
        const CancelToken& cancel;
    };

    BlockLight(const Source& source, const FaceBlock& block, LightingCost& cost)
        : source_(source), block_(block), cost_(cost), irradiance_(block.voxels().size()) {}

    /// Incomplete where cancelled.
    FaceIrradiance run() {
        if (source_.sun) add_sun();
        if (!source_.sky.black()) add_sky();
        return std::move(irradiance_);
    }

  private:
    /// A face: position in the block's list of voxels, and the region of air in front.
    struct Front {
        int region;
        uint32_t voxel;
    };

    void add_sun();
    Vec3 sun_irradiance(const BlockVoxel& voxel, int face);
    void add_sky();
    /// Voxels [begin, end) of the block's list: those of one gathering node.
    void gather_node(size_t begin, size_t end);
    void gather(int face, std::span<const Front> fronts);
    /// Numbers the regions of air in and around a gathering node.
    int region_of(const IVec3& front, const IVec3& corner);
    Vec3 point_on(const BlockVoxel& voxel, int face, double u, double v) const;
    bool visible(const Vec3& from, const Vec3& direction);

    const Source& source_;
    const FaceBlock& block_;
    LightingCost& cost_;
    FaceIrradiance irradiance_;
    std::vector<int> regions_;  // of the gathering node's cells, 0: not numbered yet
    std::vector<IVec3> open_;
    int region_count_ = 0;
};

}  // namespace probebake
