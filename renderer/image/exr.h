// Cubemaps as OpenEXR files in memory: the caller hashes, stores and names the bytes.
//
// Primary file: one part of scanlines, N × 6N on the grid of cubemap.h, channels exactly R, G, B,
// ZIP, envmap = cube, Rec.709 chromaticities, attributes owner, comments and probe:*. HALF, or
// FLOAT for the whole file when a value exceeds 65504. Nothing is clamped: values that are not
// finite or negative, and edges that are not shared, are refused. Second file (`aux`): the same
// grid with channels Z, Z2, stderr.R/G/B, samples; never inside the primary file, which single-part
// RGB readers must understand. The same input gives the same bytes: no timestamp, attributes sorted
// by name, one thread. Source: docs/conventions.md; OpenEXR 3.1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "image/cubemap.h"
#include "io/io_error.h"

namespace probebake {

/// Faces larger than this are neither written nor read (a cubemap of 1.2 GB).
inline constexpr int kMaxFaceSize_px = 4096;
/// The largest value that a HALF file holds.
inline constexpr float kHalfMax = 65504.0f;

struct ProbeAttributes {
    std::string owner;     // owner
    std::string comments;  // comments
    std::string id;        // probe:id
    std::string state;     // probe:state, the lighting state
    // probe:position, a string "x y z" that reads back to the same doubles: exrheader prints no
    // value for a v3d, and a v3f loses digits.
    Vec3 position_m{0.0};
    double near_m = 0.0;                                     // probe:near
    double far_m = std::numeric_limits<double>::infinity();  // probe:far
    std::string unit = "W.m^-2.sr^-1";                       // probe:unit; "1" for albedo states
    std::string scene_sha256;                                // probe:sceneSha256
    uint64_t seed = 0;                                       // probe:seed, a decimal string
    bool valid = true;                                       // probe:valid, 1 or 0
    /// Further attributes by their full names, which begin with "probe:" (probe:err:rmse) and have
    /// at most 255 characters.
    std::map<std::string, std::string> texts;
    std::map<std::string, double> numbers;

    bool operator==(const ProbeAttributes&) const = default;
};

struct EncodedCubemap {
    std::vector<std::byte> bytes;
    /// FLOAT, because of a value above kHalfMax: the report warns of it.
    bool is_float = false;
};

/// Throws std::domain_error with face, pixel and channel for a value that is not finite or negative
/// and for an edge pixel that differs from its owner; std::invalid_argument for a size or an
/// attribute's name that cannot be written.
EncodedCubemap encode_cubemap(const Cubemap& cubemap, const ProbeAttributes& attributes);

/// Another layout of a cubemap (layouts.h): the same channels, types and attributes. Throws as
/// above.
enum class ExrLayout { kLatlong, kPlain };
EncodedCubemap encode_layout(const Image& image, ExrLayout layout,
                             const ProbeAttributes& attributes);

/// The values that a reader of the file finds: rounded to HALF, unless the file is FLOAT. Throws
/// std::domain_error as above for a value that cannot be written.
Cubemap rounded_to_file(const Cubemap& cubemap);

struct DecodedCubemap {
    Cubemap cubemap;
    ProbeAttributes attributes;
    bool is_float = false;
};

/// Reads the primary file, whoever wrote it: attributes of ours that it lacks keep their defaults,
/// other channels are passed over. Throws IoError with `file` for everything else.
DecodedCubemap decode_cubemap(std::span<const std::byte> bytes, const std::string& file);

/// A pixel of the second file; all FLOAT, but for the count, which is UINT. +Inf is a value: of z
/// where the pixel's rays meet nothing, of the standard error where it is not known.
struct AuxPixel {
    float z_m = 0.0f;          // mean radial distance (Z)
    float z2_m2 = 0.0f;        // mean squared radial distance (Z2)
    Rgb standard_error{0.0f};  // of the pixel's radiance (stderr.R/G/B)
    uint32_t samples = 0;      // rays kept (samples)

    bool operator==(const AuxPixel&) const = default;
};

/// In the order of a cubemap's image, face_size × 6·face_size.
struct CubeAux {
    int face_size = 0;
    std::vector<AuxPixel> pixels;

    bool operator==(const CubeAux&) const = default;
};

/// Throws std::domain_error for a value that is NaN or negative, std::invalid_argument as above or
/// where the number of pixels does not fit the face size.
std::vector<std::byte> encode_aux(const CubeAux& aux, const ProbeAttributes& attributes);

struct DecodedAux {
    CubeAux aux;
    ProbeAttributes attributes;
};
DecodedAux decode_aux(std::span<const std::byte> bytes, const std::string& file);

}  // namespace probebake
