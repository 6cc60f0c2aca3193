#include "light/lighting.h"

#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "light/air_regions.h"
#include "light/block_light.h"
#include "light/face_sums.h"

namespace probebake {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

bool is_light(const Vec3& color) {
    return is_finite(color) && color.r >= 0.0 && color.g >= 0.0 && color.b >= 0.0;
}

void require(bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
}

void check(const Lighting& lighting, const LightingParams& params) {
    require(params.sun_rays >= 1 && params.sky_rays >= 1, "lighting needs rays");
    require(params.gather_level >= 0 && params.gather_level <= kMaxGatherLevel,
            "the gather level is out of range");
    if (!lighting.sun) return;
    const Sun& sun = *lighting.sun;
    require(is_finite(sun.direction) && glm::length(sun.direction) > 0.0,
            "the sun has no direction");
    require(is_light(Vec3(sun.irradiance)), "the sun's irradiance is negative or not finite");
    require(sun.angular_diameter_deg >= 0.0 && sun.angular_diameter_deg <= 90.0,
            "the sun's angular diameter is out of range");
}

class Stage {
  public:
    Stage(const VoxelTree& tree, const Lighting& lighting, const LightingParams& params,
          const CancelToken& cancel)
        : tree_(tree),
          lighting_(lighting),
          params_(params),
          cancel_(cancel),
          sky_(lighting.sky, params.sky_rays),
          emits_(lighting.emission && !tree.colors().emission.empty()) {
        for (const CubeFace face : kCubeFaces) {
            require(is_light(sky_.irradiance(face)), "the sky is negative or not finite");
        }
    }

    LitScene run() {
        const auto start = Clock::now();
        if (!tree_.empty()) {
            set_scale();
            blocks_ = node_codes(tree_, block_level(tree_));
            find_exposed();
            lay_out(tree_, out_.colors);
            light();
        }
        out_.cost.faces = out_.colors.face_count();
        out_.cost.memory_bytes = out_.colors.memory_bytes();
        out_.cost.wall_seconds = seconds_since(start);
        return std::move(out_);
    }

  private:
    template <class Visit>
    void for_each_block(Visit visit) {
        const auto first = static_cast<uint32_t>(tree_.level_begin(block_level(tree_)));
        tbb::parallel_for(size_t{0}, blocks_.size(), [&](size_t i) {
            if (cancel_.cancelled()) return;
            visit(i, FaceBlock(tree_, first + static_cast<uint32_t>(i), blocks_[i]));
        });
        cancel_.throw_if_cancelled();
    }

    /// So that the brightest that a face may become is at most half of what can be stored.
    void set_scale() {
        double brightest = 0.0;
        for (const CubeFace face : kCubeFaces) {
            const Vec3& sky = sky_.irradiance(face);
            brightest = std::max({brightest, sky.r, sky.g, sky.b});
        }
        if (lighting_.sun) {
            const Rgb& sun = lighting_.sun->irradiance;
            brightest += double{std::max({sun.r, sun.g, sun.b})};
        }
        brightest *= double{tree_.colors().albedo.scale} / std::numbers::pi;
        if (emits_) brightest += double{kPackedRgbMax * tree_.colors().emission.scale};
        if (brightest > 0.0) {
            out_.colors.scale = std::ldexp(1.0f, std::ilogb(brightest) - 13);
        }
    }

    void find_exposed() {
        out_.colors.voxels.exposed.resize(tree_.voxel_count());
        for_each_block([&](size_t, const FaceBlock& block) {
            for (const BlockVoxel& voxel : block.voxels()) {
                out_.colors.voxels.exposed[voxel.index] = voxel.exposed;
            }
        });
    }

    void light() {
        const BlockLight::Source source{tree_, lighting_.sun, sky_, params_, cancel_};
        std::vector<FaceSums> sums(blocks_.size());
        std::vector<LightingCost> costs(blocks_.size());
        for_each_block([&](size_t i, const FaceBlock& block) {
            const auto start = Clock::now();
            const FaceIrradiance light = BlockLight(source, block, costs[i]).run();
            if (!cancel_.cancelled()) sums[i] = store(block, light);
            costs[i].seconds = seconds_since(start);
        });
        for (const LightingCost& cost : costs) out_.cost += cost;
        for (int k = block_level(tree_) + 1; k < tree_.node_levels(); ++k) {
            sums = add_up_level(k, sums);
        }
    }

    /// Writes the voxels' faces and the nodes of the block; returns the sums of the block.
    FaceSums store(const FaceBlock& block, const FaceIrradiance& light) {
        const uint32_t first = block.voxels().front().index;
        FaceColors& colors = out_.colors;
        const AirRegions air(block);
        auto voxel_sums = [&](uint32_t index, const IVec3& position) {
            const uint8_t exposed = block.voxels()[index - first].exposed;
            std::array<Rgb, kFaceCount> radiance{};
            std::array<int, kFaceCount> regions{};
            for (int face = 0; face < kFaceCount; ++face) {
                const auto f = static_cast<size_t>(face);
                if (((exposed >> face) & 1u) == 0) continue;
                radiance[f] = face_radiance(index, light[index - first][f]);
                regions[f] = air.of(beside(position, face));
            }
            FaceSums sums =
                voxel_faces(position, exposed, radiance, air.count() > 1 ? &regions : nullptr);
            write_means(colors.voxels, index, sums, position, 1, colors.scale);
            return sums;
        };
        auto leaf_sums = [&](uint32_t index, const IVec3& corner) {
            return add_up(tree_, 0, index, corner, &air, voxel_sums, colors);
        };
        FaceSums sums = block_level(tree_) == 0 ? leaf_sums(block.node(), block.corner())
                                                : add_up(tree_, 1, block.node(), block.corner(),
                                                         &air, leaf_sums, colors);
        sums.leave_block();
        return sums;
    }

    Rgb face_radiance(uint32_t voxel, const Vec3& irradiance) const {
        const ColorIndex at{ColorIndex::Array::kVoxels, voxel};
        const Vec3 albedo(tree_.colors().albedo[at]);
        Vec3 radiance = albedo * irradiance / std::numbers::pi;
        if (emits_) radiance += Vec3(tree_.colors().emission[at]);
        return Rgb(radiance);
    }

    std::vector<FaceSums> add_up_level(int k, const std::vector<FaceSums>& below) {
        const auto first_below = static_cast<uint32_t>(tree_.level_begin(k - 1));
        const auto first = static_cast<uint32_t>(tree_.level_begin(k));
        const std::vector<uint64_t> codes = node_codes(tree_, k);
        std::vector<FaceSums> sums(codes.size());
        tbb::parallel_for(size_t{0}, codes.size(), [&](size_t i) {
            auto child_sums = [&](uint32_t index, const IVec3&) -> const FaceSums& {
                return below[index - first_below];
            };
            sums[i] =
                add_up(tree_, k, first + static_cast<uint32_t>(i),
                       morton_decode(codes[i]) * (4 << (2 * k)), nullptr, child_sums, out_.colors);
        });
        return sums;
    }

    const VoxelTree& tree_;
    const Lighting& lighting_;
    const LightingParams& params_;
    const CancelToken& cancel_;
    const SkyLight sky_;
    const bool emits_;
    std::vector<uint64_t> blocks_;  // Morton codes
    LitScene out_;
};

}  // namespace

int gather_level_for(double voxel_size_m, double edge_m) {
    const double level = std::round(std::log2(edge_m / voxel_size_m));
    return static_cast<int>(std::clamp(level, 0.0, double{kMaxGatherLevel}));
}

LightingCost& LightingCost::operator+=(const LightingCost& other) {
    faces += other.faces;
    gatherings += other.gatherings;
    sun_rays += other.sun_rays;
    sky_rays += other.sky_rays;
    steps += other.steps;
    seconds += other.seconds;
    wall_seconds += other.wall_seconds;
    memory_bytes += other.memory_bytes;
    return *this;
}

LitScene light_scene(const VoxelTree& tree, const Lighting& lighting, const LightingParams& params,
                     const CancelToken& cancel) {
    check(lighting, params);
    return Stage(tree, lighting, params, cancel).run();
}

}  // namespace probebake
