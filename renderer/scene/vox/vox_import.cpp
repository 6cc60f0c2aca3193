#include "scene/vox/vox_import.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <limits>

#include "io/io_error.h"
#include "scene/vox/vox_file.h"
#include "voxels/voxel_tree.h"

namespace probebake {
namespace {

using Vec3i64 = std::array<int64_t, 3>;

/// outer after inner
VoxTransform compose(const VoxTransform& outer, const VoxTransform& inner) {
    VoxTransform both;
    for (size_t i = 0; i < 3; ++i) {
        const size_t k = outer.axis[i];
        both.axis[i] = inner.axis[k];
        both.sign[i] = outer.sign[i] * inner.sign[k];
        both.translation[i] = outer.sign[i] * inner.translation[k] + outer.translation[i];
    }
    return both;
}

Vec3i64 apply(const VoxTransform& transform, const IVec3& p) {
    Vec3i64 out{};
    for (size_t i = 0; i < 3; ++i) {
        out[i] =
            transform.sign[i] * p[static_cast<int>(transform.axis[i])] + transform.translation[i];
    }
    return out;
}

/// The transform of cell indices that goes with a transform of points: the lowest corner of the
/// image of a cell is that of its highest corner along a mirrored axis.
VoxTransform cell_transform(VoxTransform points) {
    for (size_t i = 0; i < 3; ++i) {
        if (points.sign[i] < 0) --points.translation[i];
    }
    return points;
}

bool turns(const VoxTransform& transform) {
    const VoxTransform identity;
    return transform.axis != identity.axis || transform.sign != identity.sign;
}

/// Points of the file -> points of our space.
constexpr VoxTransform kZUpToYUp{.axis = {0, 2, 1}, .sign = {1, 1, -1}, .translation = {0, 0, 0}};

struct Instance {
    const VoxModel* model = nullptr;
    VoxTransform cells;  // of the model's voxels into our space
    uint64_t first_voxel = 0;
};

/// Walks the scene graph and lists what is to be placed, within the limits.
class Placement {
  public:
    Placement(const VoxFile& file, const std::string& file_name, const VoxLimits& limits)
        : file_(file), file_name_(file_name), limits_(limits), on_path_(file.nodes.size()) {
        if (file.nodes.empty()) {
            const VoxModel& model = file.models.front();
            add(model, VoxTransform{}, {model.offset_bytes, nullptr});
        } else {
            visit(0, VoxTransform{}, false, 1);
        }
    }

    std::vector<Instance> instances;
    uint64_t voxel_count = 0;
    uint64_t rotated = 0;
    uint64_t hidden = 0;
    Vec3i64 lowest{0, 0, 0};  // bounds of all voxels, both inclusive; 0 where there are none
    Vec3i64 highest{0, 0, 0};

  private:
    /// What a failure names: a node, or a model that no node places.
    struct Place {
        uint64_t offset_bytes;
        const VoxNode* node;
    };

    void visit(size_t index, const VoxTransform& above, bool hidden_above, int depth) {
        const VoxNode& node = file_.nodes[index];
        const Place place{node.offset_bytes, &node};
        if (on_path_[index]) fail(place, "is below itself in the scene graph");
        if (depth > limits_.max_depth) {
            fail(place, "is more than " + std::to_string(limits_.max_depth) + " nodes deep");
        }
        if (++visits_ > limits_.max_node_visits) {
            fail(place, "is met after " + std::to_string(limits_.max_node_visits) +
                            " others, the most that a scene graph may lead to");
        }
        const bool is_hidden = hidden_above || node.hidden;
        if (node.kind == VoxNode::Kind::kShape) {
            if (is_hidden) {
                ++hidden;
            } else {
                add(file_.models[node.references.front()], above, place);
            }
            return;
        }
        const VoxTransform below = compose(above, node.transform);
        on_path_[index] = true;
        for (const uint32_t child : node.references) visit(child, below, is_hidden, depth + 1);
        on_path_[index] = false;
    }

    void add(const VoxModel& model, const VoxTransform& points, const Place& place) {
        if (instances.size() >= std::min<uint64_t>(limits_.max_instances, kMaxInstances)) {
            fail(place,
                 "is one instance more than the limit of " + std::to_string(instances.size()));
        }
        // No overflow: at most 2^16 instances of at most 2^24 voxels.
        const uint64_t count = voxel_count + model.voxels.size();
        const uint64_t limit = std::min<uint64_t>(limits_.max_voxels, kMaxVoxels);
        if (count > limit) {
            fail(place, "brings the voxels to " + std::to_string(count) + ", the limit is " +
                            std::to_string(limit));
        }
        VoxTransform to_pivot;
        for (size_t i = 0; i < 3; ++i) {
            to_pivot.translation[i] = -(model.size[static_cast<int>(i)] / 2);
        }
        const VoxTransform turned = compose(kZUpToYUp, compose(points, to_pivot));
        const Instance instance{&model, cell_transform(turned), voxel_count};
        if (!model.voxels.empty()) extend_bounds(instance, place);
        instances.push_back(instance);
        voxel_count = count;
        if (turns(points)) ++rotated;
    }

    void extend_bounds(const Instance& instance, const Place& place) {
        const Vec3i64 a = apply(instance.cells, instance.model->lowest);
        const Vec3i64 b = apply(instance.cells, instance.model->highest);
        for (size_t i = 0; i < 3; ++i) {
            const auto [low, high] = std::minmax(a[i], b[i]);
            lowest[i] = voxel_count == 0 ? low : std::min(lowest[i], low);
            highest[i] = voxel_count == 0 ? high : std::max(highest[i], high);
            if (lowest[i] < std::numeric_limits<int32_t>::min() ||
                highest[i] > std::numeric_limits<int32_t>::max()) {
                fail(place, "lies beyond 32-bit coordinates");
            }
            const int64_t extent = highest[i] - lowest[i] + 1;
            if (extent > kMaxExtent) {
                fail(place, "brings the world to " + std::to_string(extent) +
                                " voxels along an axis, the limit is " +
                                std::to_string(kMaxExtent));
            }
        }
    }

    [[noreturn]] void fail(const Place& place, const std::string& problem) const {
        const std::string name =
            place.node != nullptr ? name_of(*place.node) : "chunk XYZI: the model";
        throw IoError(file_name_, place.offset_bytes, name + " " + problem);
    }

    static constexpr uint64_t kMaxInstances = 65'536;
    static constexpr uint64_t kMaxVoxels = std::numeric_limits<uint32_t>::max();
    static constexpr int64_t kMaxExtent = int64_t{1} << kMaxDepth;

    const VoxFile& file_;
    const std::string& file_name_;
    const VoxLimits& limits_;
    std::vector<bool> on_path_;
    uint64_t visits_ = 0;
};

/// Voxels of each model whose colour shines.
std::vector<uint64_t> count_emissive(const VoxFile& file, const VoxColors& colors) {
    std::vector<uint64_t> counts(file.models.size());
    for (size_t m = 0; m < counts.size(); ++m) {
        for (const VoxModelVoxel& v : file.models[m].voxels) {
            counts[m] += colors.emission[v.color] != 0 ? 1 : 0;
        }
    }
    return counts;
}

}  // namespace

VoxImport import_vox(std::span<const std::byte> bytes, const std::string& file_name,
                     const VoxLimits& limits) {
    const VoxFile file = parse_vox(bytes, file_name);
    const Placement placement(file, file_name, limits);
    const VoxColors colors = linear_colors(file.palette, file.materials);
    const std::vector<Instance>& instances = placement.instances;

    VoxImport result;
    result.models = file.models.size();
    result.instances = instances.size();
    result.rotated_instances = placement.rotated;
    result.hidden_instances = placement.hidden;
    result.warnings = file.warnings;
    if (file.nodes.empty() && file.models.size() > 1) {
        result.warnings.emplace_back("only the first frame of an animation is taken");
    }
    if (placement.voxel_count == 0) result.warnings.emplace_back("no voxel is visible");
    const std::vector<uint64_t> emissive = count_emissive(file, colors);
    for (const Instance& instance : instances) {
        result.emissive_voxels +=
            emissive[static_cast<size_t>(instance.model - file.models.data())];
    }

    IVec3 extent(0);
    for (size_t i = 0; i < 3; ++i) {
        result.lowest[static_cast<int>(i)] = static_cast<int>(placement.lowest[i]);
        extent[static_cast<int>(i)] =
            static_cast<int>(placement.highest[i] - placement.lowest[i] + 1);
    }
    VoxelCloud& cloud = result.cloud;
    cloud.depth = depth_for_extent(extent);
    cloud.emission_scale = colors.emission_scale;
    cloud.voxels.resize(placement.voxel_count);
    tbb::parallel_for(size_t{0}, instances.size(), [&](size_t i) {
        VoxTransform cells = instances[i].cells;
        for (size_t axis = 0; axis < 3; ++axis) cells.translation[axis] -= placement.lowest[axis];
        Voxel* out = cloud.voxels.data() + instances[i].first_voxel;
        for (const VoxModelVoxel& v : instances[i].model->voxels) {
            const Vec3i64 p = apply(cells, {v.position[0], v.position[1], v.position[2]});
            *out++ = make_voxel(
                {static_cast<int>(p[0]), static_cast<int>(p[1]), static_cast<int>(p[2])},
                colors.albedo[v.color], colors.emission[v.color], static_cast<uint16_t>(i));
        }
    });
    return result;
}

}  // namespace probebake
