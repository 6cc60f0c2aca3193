#include "bake/sh_file.h"

#include <algorithm>
#include <cmath>

#include "io/json.h"

namespace probebake {
namespace {

constexpr std::array kCoefficientNames = {"L00",  "L1-1", "L10", "L11", "L2-2",
                                          "L2-1", "L20",  "L21", "L22"};

Json write_rgb(const Vec3& c) { return {c.r, c.g, c.b}; }

Json write_coefficients(const ShRgb& coefficients) {
    Json json = Json::array();
    for (const Vec3& c : coefficients) json.push_back(write_rgb(c));
    return json;
}

Json write_interval(const Interval& interval) { return {interval.low, interval.high}; }

/// Of the irradiance.
struct ShError {
    double relative = 0.0;
    Interval interval;
    Vec3 largest;  // difference, for any normal
};

ShError error_by_draws(const ShFile& file) {
    const NormEstimate relative = relative_irradiance(*file.audit, file.radiance);
    ShError error{relative.value(), relative.interval(file.look_confidence), {}};
    for (size_t c = 0; c < file.audit->channels.size(); ++c) {
        const double norm = file.audit->channels[c].interval(file.look_confidence).high;
        error.largest[static_cast<int>(c)] = kShLargestIrradiance * norm;
    }
    return error;
}

ShError expected_error(const ExpectedIrradiance& expected) {
    const auto& [noise, square] = expected;
    const double off_by = noise.square > 0.0 ? square.interval.high / noise.square : 0.0;
    return {std::sqrt(square.value),
            {std::sqrt(square.interval.low), std::sqrt(square.interval.high)},
            kShLargestIrradiance * glm::sqrt(off_by * noise.channels)};
}

Json write_error(const ShFile& file) {
    const ShError error = file.expected ? expected_error(*file.expected) : error_by_draws(file);
    Json json = {{"draws", file.audit ? file.audit->draws : 0},
                 {"confidence", file.confidence},
                 {"irradiance_rel", error.relative},
                 {"irradiance_rel_interval", write_interval(error.interval)},
                 {"irradiance_off_by_at_most", write_rgb(error.largest)}};
    if (file.audit) {
        json["difference"] = write_coefficients(file.audit->difference);
        json["standard_error"] = write_coefficients(file.audit->standard_error);
    }
    return json;
}

}  // namespace

std::vector<std::byte> encode_sh(const ShFile& file) {
    const ProbeAttributes& probe = file.probe;
    const bool albedo = probe.unit == "1";
    const Vec3& p = probe.position_m;
    Json json = {{"product", "sh"},
                 {"owner", probe.owner},
                 {"probe", probe.id},
                 {"state", probe.state},
                 {"position_m", {p.x, p.y, p.z}},
                 {"near_m", probe.near_m},
                 {"far_m", probe.far_m},
                 {"valid", probe.valid},
                 {"scene_sha256", probe.scene_sha256},
                 {"seed", probe.seed},
                 {"quantity", albedo ? "albedo" : "radiance"},
                 {"unit", probe.unit},
                 {"primaries", "linear Rec.709, D65"},
                 {"axes", "right-handed, +Y up"},
                 {"basis", "real, orthonormal, no Condon-Shortley sign"},
                 {"order", 2},
                 {"coefficients", kCoefficientNames},
                 {"rgb", write_coefficients(file.radiance)},
                 {"irradiance_factors", {kShIrradiance[0], kShIrradiance[1], kShIrradiance[4]}}};
    const auto sky = probe.texts.find("probe:skySha256");
    if (sky != probe.texts.end()) json["sky_sha256"] = sky->second;
    if (file.audit || file.expected) json["error"] = write_error(file);
    const std::string text = dump_json(json, 2) + "\n";
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

}  // namespace probebake
