// probebake preview CUBE.exr --out PICTURE.png: a cubemap as people look at pictures.
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
    std::filesystem::path cube;
    std::filesystem::path out;
    bool panorama = false;
    int height_px = 512;
    double exposure = 0.0;
};

int preview(const PreviewOptions& options) {
    const DecodedCubemap file =
        decode_cubemap(read_file(options.cube), options.cube.filename().string());
    const double exposure =
        options.exposure > 0.0 ? options.exposure : exposure_of(file.cubemap.image().pixels());
    const ToneCurve tone{.exposure = exposure, .shoulder = true};
    write_file_atomically(
        options.out, options.panorama ? encode_panorama_png(file.cubemap, options.height_px, tone)
                                      : encode_cross_png(file.cubemap, tone));
    std::cout << options.out.string() << '\n';
    return 0;
}

}  // namespace

void add_preview_command(CLI::App& app, CommandWork& work) {
    auto* command = app.add_subcommand("preview", "Write a cubemap as a tone-mapped PNG");
    const auto options = std::make_shared<PreviewOptions>();
    command->add_option("cube", options->cube, "A cube.exr")->required();
    command->add_option("--out", options->out, "PNG file to write")->required();
    command->add_flag("--panorama", options->panorama, "Equirectangular instead of a cross");
    command->add_option("--height", options->height_px, "Height of the panorama in pixels")
        ->check(CLI::Range(1, 8192))
        ->capture_default_str();
    command->add_option("--exposure", options->exposure,
                        "Radiance shown as white; default: the 99th percentile of luminance");
    command->callback([options, &work] { work = [options] { return preview(*options); }; });
}

}  // namespace probebake
