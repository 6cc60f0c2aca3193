// The cases of voxels: places, sizes, thresholds, and values at the ends of their range.
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>

#include "image/exr.h"
#include "light/lighting.h"
#include "render/render.h"
#include "scene/scene.h"
#include "volume_study/stability.h"

namespace probebake::volume_study {
namespace {

using Cases = std::vector<StabilityCase>;

const CancelToken kNever;

VoxelCloud world_of(const std::vector<IVec3>& voxels, int depth) {
    VoxelCloud cloud{.depth = depth};
    for (const IVec3& p : voxels) {
        cloud.voxels.push_back(make_voxel(p, pack_rgb(Rgb(0.5f)), pack_rgb(Rgb(1.0f))));
    }
    return cloud;
}

/// A floor, a wall and some blocks, 32 voxels wide.
VoxelTree room() {
    std::vector<IVec3> voxels;
    for (int a = 0; a < 32; ++a) {
        for (int b = 0; b < 32; ++b) {
            voxels.push_back({a, 0, b});
            voxels.push_back({31, a, b});
            if (a % 8 == 3 && b % 8 == 3) voxels.push_back({a, 1 + b / 8, b});
        }
    }
    return VoxelTree::build(world_of(voxels, 5));
}

struct Seen {
    uint64_t bad = 0;  // values that are negative or not finite
    uint64_t hits = 0;
    double brightest = 0.0;

    void add(std::span<const Rgb> pixels) {
        for (const Rgb& pixel : pixels) {
            for (int c = 0; c < 3; ++c) {
                bad += pixel[c] >= 0.0f && std::isfinite(pixel[c]) ? 0 : 1;
                brightest = std::max(brightest, double{pixel[c]});
            }
        }
    }
};

Seen look(const VoxelTree& tree, const Vec3& from, int face_size, RendererKind kind,
          double threshold = kThesisThreshold) {
    const RenderScene scene{.tree = tree, .color = tree.colors().albedo};
    const CubemapRender render =
        render_cubemap(scene, from, face_size, {.kind = kind, .threshold = threshold}, kNever);
    Seen seen{.hits = render.total().hits()};
    seen.add(render.color.image().pixels());
    return seen;
}

enum class Expect : uint8_t { kHits, kNone };

void add(Cases& all, const std::string& name, const Seen& seen, Expect expect = Expect::kHits) {
    const auto hits = static_cast<double>(seen.hits);
    all.push_back(at_most(name, "values negative or not finite", static_cast<double>(seen.bad), 0));
    all.push_back(expect == Expect::kHits ? at_least(name, "rays that hit", hits, 1)
                                          : at_most(name, "rays that hit", hits, 0));
    all.push_back(at_most(name, "brightest albedo (all are 0.5)", seen.brightest, 0.5));
}

/// A world at 1e6 m shows what it shows at the origin: metres end at Scene::to_voxels, which leaves
/// places some 1e-9 voxels off. A ray in a thousand may pass an edge on its other side.
void far_from_the_origin(Cases& all) {
    Scene here;
    here.tree = room();
    here.voxel_size_m = 0.3;
    Scene far;
    far.tree = room();
    far.voxel_size_m = here.voxel_size_m;
    far.corner_m = Vec3(1e6, -1e6, 1e6);
    const Vec3 at_m(2.83, 2.71, 2.77);
    const auto picture = [&](const Scene& scene) {
        const RenderScene seen{.tree = scene.tree, .color = scene.tree.colors().albedo};
        return render_cubemap(seen, scene.to_voxels(scene.corner_m + at_m), 32,
                              {.kind = RendererKind::kReference}, kNever);
    };
    const CubemapRender near_picture = picture(here);
    const CubemapRender far_picture = picture(far);
    const auto& a = near_picture.color.image().pixels();
    const auto& b = far_picture.color.image().pixels();
    double differing = 0.0;
    for (size_t i = 0; i < a.size(); ++i) differing += a[i] == b[i] ? 0.0 : 1.0;
    const std::string name = "1e6 m from the origin";
    all.push_back(at_most(name, "pixels other than at the origin, of 6,144", differing, 6));
    all.push_back(
        at_least(name, "rays that hit", static_cast<double>(far_picture.total().hits()), 1));
}

void worlds(Cases& all) {
    for (const RendererKind kind : {RendererKind::kHybrid, RendererKind::kErrorAware}) {
        const std::string by = std::string(", ") + probebake::name_of(kind);
        add(all, "no voxel" + by, look(VoxelTree::build({.depth = 2}), Vec3(1.5), 16, kind),
            Expect::kNone);
        add(all, "one voxel" + by,
            look(VoxelTree::build(world_of({{1, 1, 1}}, 2)), Vec3(0.5, 1.5, 1.5), 16, kind));
        const int last = 65535;
        add(all, "65,536³ with four voxels" + by,
            look(VoxelTree::build(world_of(
                     {{0, 0, 0}, {last, last, last}, {last, 0, 0}, {32768, 32768, 32768}}, 16)),
                 Vec3(32768.5, 32770.5, 32768.5), 16, kind));
        const VoxelTree tree = room();
        add(all, "within a voxel" + by, look(tree, Vec3(31.5, 4.5, 4.5), 16, kind));
        add(all, "on a face" + by, look(tree, Vec3(5.5, 1.0, 5.5), 16, kind));
        add(all, "on an edge" + by, look(tree, Vec3(31.0, 1.0, 5.5), 16, kind));
        add(all, "on a corner" + by, look(tree, Vec3(4.0, 1.0, 4.0), 16, kind));
        for (const int size : {1, 2}) {
            add(all, "face size " + std::to_string(size) + by, look(tree, Vec3(9.3), size, kind));
        }
    }
    const VoxelTree tree = room();
    for (const double threshold : {0.0, 1.0}) {
        add(all, "threshold " + study::decimals(threshold, 0) + ", error_aware",
            look(tree, Vec3(9.3), 32, RendererKind::kErrorAware, threshold));
    }
}

/// A whole cube of the largest faces, one at a time to spare memory.
void largest_cube(Cases& all, const std::string& world, const VoxelTree& tree, const Vec3& from) {
    constexpr int kLargest = 4096;
    const RenderScene scene{.tree = tree, .color = tree.colors().albedo};
    for (const RendererKind kind : {RendererKind::kHybrid, RendererKind::kLod}) {
        Seen seen;
        uint64_t pixels = 0;
        for (const CubeFace face : kCubeFaces) {
            const ViewRender view = render_view(scene, cube_face_view(face, kLargest, from),
                                                {.kind = kind}, kNever, {.face = face});
            seen.add(view.color.pixels());
            seen.hits += view.stats.hits();
            pixels += view.pixels;
        }
        const std::string name =
            "face size 4096, " + world + ", " + std::string(probebake::name_of(kind));
        add(all, name, seen);
        const uint64_t expected = owned_pixel_count(kLargest);
        all.push_back({.name = name,
                       .checked = "pixels that the six faces own",
                       .value = study::grouped_digits(pixels),
                       .bound = study::grouped_digits(expected),
                       .pass = pixels == expected});
    }
}

/// The brightest pixel of a voxel that emits, over its emission.
double shown_emission(float radiance, int exponent) {
    VoxelCloud cloud{.depth = 2};
    cloud.emission_scale = std::ldexp(1.0f, exponent);
    cloud.voxels.push_back(
        make_voxel({1, 1, 1}, pack_rgb(Rgb(0.5f)), pack_rgb(Rgb(radiance / cloud.emission_scale))));
    const VoxelTree tree = VoxelTree::build(std::move(cloud));
    const RenderScene scene{.tree = tree, .color = tree.colors().emission};
    Seen seen;
    seen.add(render_cubemap(scene, {0.5, 1.5, 1.5}, 16, {.kind = RendererKind::kHybrid}, kNever)
                 .color.image()
                 .pixels());
    return seen.bad == 0 ? seen.brightest / double{radiance} : -1.0;
}

void emissions(Cases& all) {
    for (const float radiance : {1e-30f, 1e30f}) {
        const double shown = shown_emission(radiance, radiance > 1.0f ? 90 : -110);
        all.push_back({.name = radiance > 1.0f ? "emission 1e30" : "emission 1e-30",
                       .checked = "of a voxel: brightest pixel over it",
                       .value = short_text(shown),
                       .bound = "1 ± 0.002",
                       .pass = std::abs(shown - 1.0) < 0.002});
        Cubemap cube(4);
        for (Rgb& pixel : cube.image().pixels()) pixel = Rgb(radiance);
        const EncodedCubemap file = encode_cubemap(cube, {});
        const Cubemap back = decode_cubemap(file.bytes, "stability").cubemap;
        const double value = double{back.image().pixels()[0].r};
        const bool large = radiance > 1.0f;
        const std::string type = file.is_float ? "FLOAT, " : "HALF, ";
        all.push_back(
            {.name = large ? "emission 1e30" : "emission 1e-30",
             .checked = large ? "in the file: kept, as FLOAT"
                              : "in the file: off by at most HALF's smallest step",
             .value = type + short_text(value),
             .bound = large ? "FLOAT, 1e+30" : "HALF, 1e-30 ± 6e-08",
             .pass = large ? file.is_float && value == double{radiance}
                           : !file.is_float && std::abs(value - double{radiance}) <= 0x1.0p-24});
    }
}

void bad_input(Cases& all) {
    const VoxelTree tree = room();
    int refused = 0;
    int tried = 0;
    const auto refuse = [&](auto call) {
        ++tried;
        try {
            call();
        } catch (const std::exception&) {
            ++refused;
        }
    };
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (const float bad : {kNan, kInfinity, -1.0f}) {
        refuse([&] {
            Lighting lighting;
            lighting.sun = Sun{.irradiance = Rgb(1.0f, bad, 1.0f)};
            light_scene(tree, lighting, {}, kNever);
        });
        refuse([&] {
            Lighting lighting;
            lighting.sky = Sky(Rgb(bad));
            light_scene(tree, lighting, {}, kNever);
        });
        refuse([&] {
            Cubemap cube(2);
            for (Rgb& pixel : cube.image().pixels()) pixel = Rgb(bad);
            encode_cubemap(cube, {});
        });
    }
    refuse([&] {
        Lighting lighting;
        lighting.sun = Sun{.direction = Vec3(std::numeric_limits<double>::quiet_NaN(), 1.0, 0.0)};
        light_scene(tree, lighting, {}, kNever);
    });
    all.push_back(at_least("NaN, infinite, negative light and pixels",
                           "refused, of " + std::to_string(tried), refused, tried));
}

}  // namespace

std::vector<StabilityCase> voxel_cases(bool full) {
    Cases all;
    far_from_the_origin(all);
    worlds(all);
    largest_cube(all, "one voxel", VoxelTree::build(world_of({{1, 1, 1}}, 2)), {0.5, 1.5, 1.5});
    if (full) largest_cube(all, "a room", room(), Vec3(9.3));
    emissions(all);
    bad_input(all);
    return all;
}

}  // namespace probebake::volume_study
