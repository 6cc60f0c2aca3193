// Points on emissive voxels drawn by power over squared distance, for next-event estimation.
//
// The emissive voxels that have an exposed face are kept in the order of the tree (Morton), with a
// binary tree over them: level 0 are the voxels, node i of a level joins nodes 2i and 2i + 1 of the
// one below. A node has the power of its voxels (mean of the channels × exposed faces), their box
// and the directions that their faces look to. A sample goes from the root to the child that power
// over squared distance favours (to the box's middle, at least half the box's diagonal), never to
// one whose faces all look away; then to one of the voxel's faces that front the point, by the
// point's height above them, and to a point of that face, uniformly.
//
// 20 bytes a node: 44 bytes per voxel. Space: voxels (voxel_tree.h). The density of a sample says
// how a hit of the same face weighs against it, so that what is drawn wrongly costs variance only.
#pragma once

#include <optional>
#include <vector>

#include "voxels/trace.h"

namespace probebake {

class EmitterSampler {
  public:
    /// Beyond that many a sampler has none: so many voxels are found by scattering.
    static constexpr size_t kMostEmitters = size_t{1} << 20;

    explicit EmitterSampler(const VoxelTree& tree);

    bool empty() const { return voxels_.empty(); }
    size_t size() const { return voxels_.size(); }
    /// Emissive voxels with an exposed face in the tree, whether they are kept or not.
    uint64_t found() const { return found_; }
    /// Of these, root mean square over the channels.
    double largest_radiance() const { return largest_radiance_; }
    /// Steps from the root of the binary tree to a voxel.
    int levels() const { return static_cast<int>(levels_.size()) - 1; }
    uint64_t memory_bytes() const;

    struct Sample {
        IVec3 corner{0};  // of the voxel
        CubeFace face = CubeFace::kPosX;
        Vec3 point{0.0};           // on that face
        double probability = 0.0;  // of the face
    };
    /// None where nothing that emits looks towards `from`. u[i] in [0, 1).
    std::optional<Sample> sample(const Vec3& from, const std::array<double, 3>& u) const;

    /// The probability that sample() chooses the face of that voxel; 0 for what is not among the
    /// emitters.
    double probability(const Vec3& from, uint32_t voxel, CubeFace face) const;

    /// Per sr, of a direction drawn as a point of a face at that distance.
    static double density(double probability, double distance, double cosine) {
        return probability * distance * distance / cosine;
    }

  private:
    struct Node {
        float power = 0.0f;
        std::array<uint16_t, 3> low{};   // lowest voxel
        std::array<uint16_t, 3> high{};  // highest voxel
        uint8_t faces = 0;               // bit f: a face of direction f is exposed

        double importance(const Vec3& from) const;
        Node& operator+=(const Node& other);
    };

    /// The share of the left of two children.
    double left_share(size_t level, size_t left, const Vec3& from) const;

    std::vector<std::vector<Node>> levels_;  // from the voxels up
    std::vector<uint32_t> voxels_;           // index in the tree, ascending
    uint64_t found_ = 0;
    double largest_radiance_ = 0.0;
};

}  // namespace probebake
