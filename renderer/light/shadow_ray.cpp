#include "light/shadow_ray.h"

#include "error/octant_error.h"

namespace probebake {
namespace {

const OctantErrorTable& error_codes() {
    static const OctantErrorTable table;
    return table;
}

class SolidRule : public StopRule {
  public:
    SolidRule(const VoxelTree& tree, const Ray& ray, double distance,
              const ShadowSettings& settings)
        : tree_(tree),
          ray_(ray),
          far_end_(ray.origin + ray.direction * distance),
          settings_(settings) {}

    bool stops(const Hit& node) override {
        if (holds_far_end(node)) return false;
        switch (settings_.lod) {
            case ShadowLod::kDistance:
                return true;
            case ShadowLod::kNode:
                return node_is_solid(node);
            case ShadowLod::kSubtree:
                break;
        }
        return subtree_is_solid(node);
    }
    uint32_t errors_asked() const { return errors_asked_; }

  private:
    /// False for an infinite far end.
    bool holds_far_end(const Hit& node) const {
        const Vec3 from = far_end_ - Vec3(node.corner);
        const double edge = 1 << node.level;
        return from.x >= 0.0 && from.y >= 0.0 && from.z >= 0.0 && from.x <= edge &&
               from.y <= edge && from.z <= edge;
    }

    bool node_is_solid(const Hit& node) {
        const ChildMasks masks = child_masks(tree_, node);
        errors_asked_ += 1u + masks.child_count;
        const double error =
            node_error(thesis_error_table(), ray_.direction, masks.own,
                       std::span(masks.children).first(masks.child_count), settings_.decay);
        return !needs_refinement(error, settings_.threshold);
    }

    bool subtree_is_solid(const Hit& node) {
        const auto k =
            static_cast<size_t>(node.level % 2 == 0 ? node.level / 2 - 1 : node.level / 2);
        if (node.level % 2 == 0) return is_solid(static_cast<int>(k), node.path[k]);
        const ColorIndex octant = color_index(tree_, node, node.level);
        const VoxelNode& holder = tree_.nodes()[node.path[k]];
        const uint32_t rank = octant.index - holder.octant_base;
        uint32_t child = holder.first_child;
        uint32_t seen = 0;
        for (uint64_t rest = holder.mask; rest != 0; rest >>= 8) {
            const auto mask = static_cast<uint8_t>(rest & 0xFFu);
            if (mask == 0) continue;
            if (seen++ == rank) return octant_is_solid(static_cast<int>(k), mask, child);
            child += static_cast<uint32_t>(std::popcount(mask));
        }
        return false;
    }

    /// A 64-ary node of node level k and all below it.
    bool is_solid(int k, uint32_t index) {
        const VoxelNode& node = tree_.nodes()[index];
        if (!mask_is_solid(static_cast<uint8_t>(nonzero_bytes(node.mask)))) return false;
        uint32_t child = node.first_child;
        for (uint64_t rest = node.mask; rest != 0; rest >>= 8) {
            const auto mask = static_cast<uint8_t>(rest & 0xFFu);
            if (mask == 0) continue;
            if (!octant_is_solid(k, mask, child)) return false;
            child += static_cast<uint32_t>(std::popcount(mask));
        }
        return true;
    }

    bool octant_is_solid(int k, uint8_t mask, uint32_t first_child) {
        if (!mask_is_solid(mask)) return false;
        if (k == 0) return true;
        const auto children = static_cast<uint32_t>(std::popcount(mask));
        for (uint32_t i = 0; i < children; ++i) {
            if (!is_solid(k - 1, first_child + i)) return false;
        }
        return true;
    }

    bool mask_is_solid(uint8_t mask) {
        ++errors_asked_;
        if (mask == 255) return true;
        return !needs_refinement(error_codes().error(ray_.direction, mask), settings_.threshold);
    }

    const VoxelTree& tree_;
    const Ray& ray_;
    const Vec3 far_end_;
    const ShadowSettings& settings_;
    uint32_t errors_asked_ = 0;
};

}  // namespace

ShadowResult cast_shadow_ray(const VoxelTree& tree, const Ray& ray, double distance,
                             const ShadowSettings& settings) {
    const LevelOfDetail lod{.cone = settings.cone};
    const TraceRange range{.t_min = 0.0, .t_max = distance};
    ShadowResult result;
    if (settings.cone > 0.0) {
        SolidRule rule(tree, ray, distance, settings);
        result.blocker = trace(tree, ray, lod, range, rule);
        result.errors_asked = rule.errors_asked();
    } else {
        result.blocker = trace(tree, ray, lod, range);
    }
    result.visible = !(result.blocker.t < distance);
    return result;
}

}  // namespace probebake
