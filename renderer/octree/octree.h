// Octree: an 8-ary tree over a box, whose nodes are split by three axis-parallel planes of their
// own.
//
// An inner node holds its three planes and eight references; a reference is an inner node, or a
// leaf and its number, whose meaning is the owner's. Octant i lies above plane a where bit a of i
// is set (x: bit 0). Every inner node has all eight children, so that there are 7 inner + 1 leaves.
// An inner node takes 56 bytes, a leaf none.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/affine.h"

namespace probebake {

/// The root is depth 0.
inline constexpr int kMaxOctreeDepth = 20;

class OctreeRef {
  public:
    static constexpr OctreeRef node(uint32_t index) { return OctreeRef(index); }
    static constexpr OctreeRef leaf(uint32_t number) { return OctreeRef(number | kLeaf); }
    /// A leaf whose owner has nothing to say about it.
    static constexpr OctreeRef empty_leaf() { return OctreeRef(~uint32_t{0}); }

    constexpr OctreeRef() : bits_(~uint32_t{0}) {}
    constexpr bool is_leaf() const { return (bits_ & kLeaf) != 0; }
    constexpr bool is_empty() const { return bits_ == ~uint32_t{0}; }
    /// Of the node, or of the leaf.
    constexpr uint32_t number() const { return bits_ & ~kLeaf; }

    friend constexpr bool operator==(OctreeRef, OctreeRef) = default;

  private:
    static constexpr uint32_t kLeaf = uint32_t{1} << 31;
    explicit constexpr OctreeRef(uint32_t bits) : bits_(bits) {}
    uint32_t bits_;
};

class Octree {
  public:
    struct Node {
        Vec3 planes{0.0};
        std::array<OctreeRef, 8> children{};
    };

    /// One empty leaf.
    Octree() = default;
    explicit Octree(const Box& box) : box_(box) {}

    const Box& box() const { return box_; }
    OctreeRef root() const { return root_; }
    const Node& node(OctreeRef ref) const { return nodes_[ref.number()]; }
    const std::vector<Node>& nodes() const { return nodes_; }

    /// A new inner node of eight empty leaves; whoever builds puts it where it belongs.
    OctreeRef add_node(const Vec3& planes);
    void set_root(OctreeRef root) { root_ = root; }
    void set_child(OctreeRef parent, int octant, OctreeRef child) {
        nodes_[parent.number()].children[static_cast<size_t>(octant)] = child;
    }

  private:
    Box box_;
    OctreeRef root_;
    std::vector<Node> nodes_;
};

/// The part of a node's box that an octant takes.
Box octant_box(const Box& box, const Vec3& planes, int octant);

}  // namespace probebake
