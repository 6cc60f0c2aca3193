// probebake preview CUBE.exr --out PICTURE.png: a cubemap as people look at pictures.
#include <algorithm>
#include <iostream>
#include <memory>

#include "commands/commands.h"
#include "image/exposure.h"
#include "image/exr.h"
#include "image/preview.h"
#include "io/file.h"

namespace probebake {
namespace {

struct PreviewOptions {
    std::filesystem::path cube;  // or aux
    std::filesystem::path out;
    bool panorama = false;
    int height_px = 512;
    double exposure = 0.0;
    bool samples = false;
};

/// Rays per pixel, the most of any pixel white.
Cubemap sample_picture(const CubeAux& aux) {
    uint32_t most = 2;
    for (const AuxPixel& pixel : aux.pixels) most = std::max(most, pixel.samples);
    Cubemap picture(aux.face_size);
    for (size_t i = 0; i < aux.pixels.size(); ++i) {
        picture.image().pixels()[i] = count_grey(aux.pixels[i].samples, most);
    }
    return picture;
}

int preview(const PreviewOptions& options) {
    const std::vector<std::byte> bytes = read_file(options.cube);
    const std::string name = options.cube.filename().string();
    Cubemap cubemap;
    ToneCurve tone{.exposure = 1.0, .shoulder = false};
    if (options.samples) {
        cubemap = sample_picture(decode_aux(bytes, name).aux);
    } else {
        cubemap = decode_cubemap(bytes, name).cubemap;
        tone = {.exposure = options.exposure > 0.0 ? options.exposure
                                                   : exposure_of(cubemap.image().pixels()),
                .shoulder = true};
    }
    write_file_atomically(options.out, options.panorama
                                           ? encode_panorama_png(cubemap, options.height_px, tone)
                                           : encode_cross_png(cubemap, tone));
    std::cout << options.out.string() << '\n';
    return 0;
}

}  // namespace

void add_preview_command(CLI::App& app, CommandWork& work) {
    auto* command = app.add_subcommand("preview", "Write a cubemap as a tone-mapped PNG");
    const auto options = std::make_shared<PreviewOptions>();
    command->add_option("cube", options->cube, "A cube.exr; with --samples an aux.exr")->required();
    command->add_option("--out", options->out, "PNG file to write")->required();
    command->add_flag("--panorama", options->panorama, "Equirectangular instead of a cross");
    command->add_option("--height", options->height_px, "Height of the panorama in pixels")
        ->check(CLI::Range(1, 8192))
        ->capture_default_str();
    command->add_option("--exposure", options->exposure,
                        "Radiance shown as white; default: the 99th percentile of luminance");
    command->add_flag(
        "--samples", options->samples,
        "The file is an aux.exr: show its rays per pixel, 1 black, the most white, on "
        "a logarithmic scale");
    command->callback([options, &work] { work = [options] { return preview(*options); }; });
}

}  // namespace probebake
