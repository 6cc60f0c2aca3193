// Every product at every kind of face size, HALF and FLOAT, on any number of threads.
#include <ImfChannelList.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "bake/bake_fixture.h"
#include "bake/bake_probe.h"
#include "image/exr.h"
#include "image/exr_file.h"
#include "image/layouts.h"
#include "image/specular.h"

namespace probebake {
namespace {

constexpr float kLamp = 1048576.0f;  // 2²⁰: a 1e6 emitter

/// A ceiling that shines with 2²⁰, a wall that reflects a half.
Scene lamp_scene() {
    VoxelCloud cloud{.emission_scale = kLamp, .depth = 4};
    for (int a = 0; a < 16; ++a) {
        for (int b = 0; b < 16; ++b) {
            cloud.voxels.push_back(make_voxel({12, a, b}, pack_rgb(Rgb(0.5f))));
            cloud.voxels.push_back(
                make_voxel({a, 15, b}, pack_rgb(Rgb(0.25f)), pack_rgb(Rgb(1.0f)), 1));
        }
    }
    Scene scene = test::small_scene();
    scene.tree = VoxelTree::build(cloud);
    return scene;
}

struct Case {
    int face_size_px;
    bool bright;
};

class ProductSizes : public testing::TestWithParam<Case> {
  protected:
    Json request() const {
        Json request = test::small_request(1);
        const Vec3 p = scene_.to_metres(Vec3(4.5, 4.5, 4.5));
        request["probes"] = {{"grids",
                              {{{"id", "g"},
                                {"origin_m", {p.x, p.y, p.z}},
                                {"spacing_m", {0.5, 0.5, 0.5}},
                                {"counts", {1, 1, 1}}}}}};
        request["face_size_px"] = GetParam().face_size_px;
        request["products"] = {"cube", "aux", "latlong", "gl_faces", "sh", "specular", "ddgi"};
        if (GetParam().face_size_px > 64) {
            request["quality"] = {{"renderer", "lod"},
                                  {"settings", Json::object()},
                                  {"evidence", {{"audit", false}}}};
        }
        return request;
    }
    LightingState state() const {
        return GetParam().bright ? LightingState::kEmission : LightingState::kAlbedo;
    }
    ProbeResult bake(int threads) const {
        const JobSpec job = read_job(request());
        ProbeResult result;
        tbb::task_arena arena(threads);
        arena.execute([&] {
            const Pilot pilot = run_pilot(scene_, job, make_plan(scene_, job), state(), cancel_);
            result = bake_probe(scene_, job, pilot, {.probe = 0}, cancel_);
        });
        GridResult atlas = encode_ddgi(
            job.grids[0], ddgi_atlas(IVec3(1), std::vector<const DdgiTile*>{&*result.ddgi}), {});
        for (ProductFile& file : atlas.files) result.files.push_back(std::move(file));
        return result;
    }

    Scene scene_ = lamp_scene();
    CancelToken cancel_;
};

/// The largest value of R, G and B, and the type that they are stored in.
struct Channels {
    int width = 0;
    int height = 0;
    float largest = 0.0f;
    bool is_float = false;
};
Channels read_channels(const ProductFile& file) {
    ExrReader reader(file.bytes, file.name, 16'384, 6 * kMaxFaceSize_px);
    Channels out{reader.width(), reader.height()};
    Image image(out.width, out.height);
    auto* const first = std::as_writable_bytes(image.pixels()).data();
    std::vector<ExrChannel<std::byte>> channels = {{"R", Imf::FLOAT, first, sizeof(Rgb)},
                                                   {"G", Imf::FLOAT, first + 4, sizeof(Rgb)}};
    reader.read(channels);
    for (const Rgb& c : image.pixels()) out.largest = std::max({out.largest, c.r, c.g});
    out.is_float = reader.header().channels()["R"].type == Imf::FLOAT;
    return out;
}

TEST_P(ProductSizes, IsRightAndTheSameOnAnyNumberOfThreads) {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    const auto [n, bright] = GetParam();
    const ProbeResult result = bake(7);
    if (n >= 4) {
        EXPECT_EQ(result.is_float, bright);
    }
    const float lamp = bright ? kLamp : 0.5f;
    const int mips = specular_mips(n);
    ASSERT_EQ(result.files.size(), 10U + static_cast<size_t>(mips) + 2U);
    for (const ProductFile& file : result.files) {
        if (file.name == "sh.json") {
            const Json sh =
                parse_json({reinterpret_cast<const char*>(file.bytes.data()), file.bytes.size()});
            EXPECT_GT(sh["rgb"][0][1].get<float>(), 0.1f * lamp);
            EXPECT_EQ(sh.contains("error"), n <= 64);
            continue;
        }
        if (file.name == "aux.exr") {
            const CubeAux aux = decode_aux(file.bytes, file.name).aux;
            EXPECT_EQ(aux.face_size, n);
            for (const AuxPixel& pixel : aux.pixels) EXPECT_GE(pixel.samples, 1U);
            continue;
        }
        const Channels read = read_channels(file);
        if (file.name == "ddgi-distance.exr") {
            EXPECT_EQ(read.width, 16);
            EXPECT_TRUE(read.is_float);
            continue;
        }
        EXPECT_EQ(read.is_float, read.largest > kHalfMax) << file.name;
        EXPECT_LE(read.largest, lamp * 1.0001f) << file.name;
        if (file.name == "ddgi-irradiance.exr") {
            EXPECT_EQ(read.width, 8);
        } else if (file.name == "latlong.exr") {
            EXPECT_EQ(read.width, latlong_width(n));
        } else if (file.name == "cube.exr" || file.name.starts_with("specular")) {
            const int mip = file.name == "cube.exr" ? 0 : file.name.at(9) - '0';
            EXPECT_EQ(read.width, n >> mip) << file.name;
            const DecodedCubemap cube = decode_cubemap(file.bytes, file.name);
            if (file.name != "cube.exr") {
                EXPECT_EQ(cube.attributes.numbers.at("probe:specular:roughness"),
                          specular_roughness(mip, mips));
                EXPECT_FALSE(cube.attributes.numbers.contains("probe:err:rmse"));
            }
            if (mip == 0 && n >= 16) {
                EXPECT_EQ(read.largest, lamp) << file.name;
            }
        } else {
            EXPECT_EQ(read.width, n) << file.name;
        }
        // Of the GL faces, the one that sees the lamp. (Pixels below are as wide as the lamp.)
        const bool looks_away =
            file.name.size() == 6 && file.name != (bright ? "py.exr" : "px.exr");
        if (n >= 4 && !looks_away) {
            EXPECT_GT(read.largest, 0.1f * lamp) << file.name;
        }
    }
    const ProbeResult alone = bake(1);
    ASSERT_EQ(alone.files.size(), result.files.size());
    for (size_t i = 0; i < alone.files.size(); ++i) {
        EXPECT_EQ(alone.files[i].sha256, result.files[i].sha256) << alone.files[i].name;
    }
}

std::string case_name(const testing::TestParamInfo<Case>& info) {
    return std::to_string(info.param.face_size_px) + (info.param.bright ? "Float" : "Half");
}

#ifdef PROBEBAKE_LARGE_FACES  // a test of its own: half a minute each
INSTANTIATE_TEST_SUITE_P(Large, ProductSizes, testing::Values(Case{512, false}, Case{512, true}),
                         case_name);
#else
INSTANTIATE_TEST_SUITE_P(Small, ProductSizes,
                         testing::Values(Case{1, false}, Case{1, true}, Case{2, false},
                                         Case{2, true}, Case{4, false}, Case{4, true},
                                         Case{16, false}, Case{16, true}, Case{64, false},
                                         Case{64, true}),
                         case_name);
#endif

}  // namespace
}  // namespace probebake
