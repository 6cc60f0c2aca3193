// The cases of what comes from outside: wherever a number may stand that is none, it is refused, or
// no file can say it.
#include <unistd.h>

#include <cmath>
#include <limits>

#include "bake/job_spec.h"
#include "image/exr_file.h"
#include "image/hdr.h"
#include "io/file.h"
#include "light/sky_file.h"
#include "scene/scene_library.h"
#include "scene/vox/vox_import.h"
#include "volume_study/stability_input.h"

namespace probebake::volume_study {
namespace {

using Cases = std::vector<StabilityCase>;

void add(Cases& all, const std::string& what, const Refusals& got) {
    all.push_back(refused_numbers(what, got));
}

void requests(Cases& all) {
    const std::string job = R"({"scene": "any", "face_size_px": 16, "seed": 3, "near_m": 0.1,
        "far_m": 100, "probes": {"list": [{"id": "a", "position_m": [1, 2, 3]}],
        "grids": [{"id": "g", "origin_m": [0, 0, 0], "spacing_m": [1, 1, 1], "counts": [2, 2, 2]}]},
        "lighting_states": [{"id": "day", "sun": {"direction": [1, 2, 3],
        "irradiance_w_m2": [3, 2, 1], "angular_diameter_deg": 0.5},
        "sky": {"type": "gradient", "zenith_w_m2_sr": [1, 2, 3], "horizon_w_m2_sr": [3, 2, 1],
        "ground_w_m2_sr": [0, 0, 0]}}],
        "quality": {"targets": {"rmse": 0.1, "psnr_db": 30}, "exposure": 1.5},
        "budget": {"seconds": 10, "rays": 1000000}})";
    read_job(parse_json(job));  // as it stands it is a job
    add(all, "numbers of a request (positions, sun, sky, targets, budgets)",
        with_every_number(job, [](const std::string& text) { read_job(parse_json(text)); }));
}

void scene_files(Cases& all) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() /
                                         ("probebake-stability-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    const std::filesystem::path path = folder / "scene.json";
    const auto read = [&](const std::string& text) {
        write_file_atomically(path, text);
        read_scene_file(path);
    };
    const std::string media = R"("origin_m": [1, 2, 3], "media": [
        {"type": "homogeneous", "scattering_per_m": [1, 2, 3], "absorption_per_m": [1, 2, 3],
         "emission_w_m2_sr": [1, 2, 3], "g": 0.5,
         "box_m": {"low": [0, 0, 0], "high": [1, 1, 1]}},
        {"type": "fog", "scattering_per_m": [1, 2, 3], "base_m": 3, "scale_height_m": 10},
        {"type": "cumulus", "scattering_per_m": [1, 2, 3], "size": 32, "seed": 1,
         "width_m": 20, "rotation_deg": 10, "origin_m": [1, 2, 3]}]})";
    for (const char* name : {"a.png", "a.vox", "a.glb", "a.obj", "a.nff"}) {
        write_file_atomically(folder / name, std::string("not read here"));
    }
    Refusals sum;
    for (const char* type :
         {R"({"type": "generator", "generator": "mountain", "size": 64, "seed": 1, )",
          R"({"type": "vox", "file": "a.vox", "voxel_size_m": 0.1, )",
          R"({"type": "heightmap", "file": "a.png", "voxel_size_m": 1, "height_scale_m": 0.1, )",
          R"({"type": "gltf", "file": "a.glb", "voxel_size_m": 0.1, "emission_scale": 2, )",
          R"({"type": "obj", "file": "a.obj", "resolution": 64, "unit_m": 0.5, )",
          R"({"type": "nff", "file": "a.nff", "voxel_size_m": 0.1, "unit_m": 0.5, )"}) {
        const std::string scene = type + media;
        read(scene);  // as it stands it is a scene
        sum += with_every_number(scene, read);
    }
    add(all, "numbers of scene files (generated, .vox, heights, meshes; media of all kinds)", sum);
    std::filesystem::remove_all(folder);
}

void skies(Cases& all) {
    constexpr int kWidth = 8;
    Refusals exr;
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0f}) {
        for (size_t at = 0; at < 3; ++at) {
            std::vector<Rgb> pixels(kWidth * kWidth / 2, Rgb(1.0f));
            pixels[10][static_cast<int>(at)] = bad;
            std::vector<ExrChannel<const std::byte>> channels;
            for (const char* name : {"R", "G", "B"}) {
                const auto* first = reinterpret_cast<const std::byte*>(pixels.data());
                channels.push_back({name, Imf::FLOAT, first + 4 * channels.size(), sizeof(Rgb)});
            }
            const auto file = encode_exr(Imf::Header(kWidth, kWidth / 2), channels);
            exr.expect_refusal([&] { decode_sky(file, "sky.exr"); });
        }
    }
    add(all, "pixels of a sky, OpenEXR", exr);

    // Radiance: every exponent with mantissas at their ends.
    std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n";
    for (int exponent = 0; exponent < 256; ++exponent) {
        for (const int mantissa : {1, 255}) {
            for (int channel = 0; channel < 3; ++channel) hdr += static_cast<char>(mantissa);
            hdr += static_cast<char>(exponent);
        }
    }
    double bad = 0.0;
    const auto image = decode_sky(std::as_bytes(std::span(hdr)), "sky.hdr");
    for (const Rgb& pixel : image->pixels()) {
        bad += is_finite(Vec3(pixel)) && pixel.r >= 0.0f ? 0.0 : 1.0;
    }
    all.push_back(at_most("NaN anywhere in the input",
                          "pixels of a sky, Radiance, all exponents: negative or not finite", bad,
                          0));
}

std::string int32(uint32_t value) {
    std::string out;
    for (int byte = 0; byte < 4; ++byte) out += static_cast<char>(value >> (8 * byte) & 255u);
    return out;
}
std::string chunk(const std::string& id, const std::string& content, const std::string& inner) {
    return id + int32(static_cast<uint32_t>(content.size())) +
           int32(static_cast<uint32_t>(inner.size())) + content + inner;
}

/// The only reals of .vox files, written as texts.
void vox_materials(Cases& all) {
    const auto text = [](const std::string& s) {
        return int32(static_cast<uint32_t>(s.size())) + s;
    };
    const auto import = [&](const std::string& emit, const std::string& flux) {
        const std::string material = int32(1) + int32(3) + text("_type") + text("_emit") +
                                     text("_emit") + text(emit) + text("_flux") + text(flux);
        const std::string file =
            "VOX " + int32(150) +
            chunk("MAIN", "",
                  chunk("SIZE", int32(1) + int32(1) + int32(1), "") +
                      chunk("XYZI", int32(1) + std::string("\0\0\0\1", 4), "") +
                      chunk("MATL", material, ""));
        import_vox(std::as_bytes(std::span(file)), "a.vox");
    };
    import("0.5", "2");  // as it stands it is a world
    Refusals got;
    for (const char* bad : {"nan", "NaN", "-nan", "inf", "-inf", "infinity", "1e999"}) {
        got.expect_refusal([&] { import(bad, "2"); });
        got.expect_refusal([&] { import("0.5", bad); });
    }
    add(all, "emission of .vox materials (places and colours are integers)", got);
}

}  // namespace

std::vector<StabilityCase> input_cases() {
    Cases all;
    requests(all);
    scene_files(all);
    skies(all);
    vox_materials(all);
    for (StabilityCase& one : mesh_input_cases()) all.push_back(std::move(one));
    for (StabilityCase& one : vdb_cases()) all.push_back(std::move(one));
    return all;
}

}  // namespace probebake::volume_study
