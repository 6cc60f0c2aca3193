// NFF, Haines's Neutral File Format 3.9, in which the Standard Procedural Databases come.
//
// All its statements: v, b, l, f, c, s, p, pp, and comments. As the format asks, the view comes
// first and once, lights come before objects, an object takes the last f before it. Statements are
// separated by white space of any kind. Coordinates are the file's.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "objects/object_set.h"

namespace probebake {

struct NffView {
    Vec3 from{0.0};
    Vec3 at{0.0};
    Vec3 up{0.0};
    double angle_deg = 0.0;  // between the centres of the first and the last row of pixels
    double hither = 0.0;
    int width_px = 0;
    int height_px = 0;
};

struct NffLight {
    Vec3 position{0.0};
    std::optional<Rgb> color;
};

struct NffMaterial {
    Rgb color{0.0f};
    double diffuse = 0.0;   // Kd
    double specular = 0.0;  // Ks
    double shine = 0.0;     // Phong's cosine power
    double transmittance = 0.0;
    double refraction_index = 0.0;
};

struct NffObject {
    uint32_t material = 0;
    /// Negative radii in the file: the inside is visible.
    bool inward = false;
    /// Of pp: where its vertices' normals begin, one per vertex.
    std::optional<uint32_t> first_normal;
};

struct NffScene {
    std::optional<NffView> view;
    Rgb background{0.0f};
    std::vector<NffLight> lights;
    std::vector<NffMaterial> materials;
    ObjectSet shapes;
    std::vector<NffObject> objects;  // one per shape
    std::vector<Vec3> normals;
};

/// Throws IoError with the line, what was expected and what stands there instead.
NffScene parse_nff(std::string_view text, const std::string& file);
NffScene read_nff(const std::filesystem::path& path);

}  // namespace probebake
