// A cubemap on OpenEXR's cube-face grid: N wide, 6N high, faces from the top +X −X +Y −Y +Z −Z.
//
// Pixel centres lie ON the edges of the cube: pixel x of a face is at u = (2x − (N−1)) / (N−1).
//
//   face  u            v            right / up seen from inside    direction of (u, v)
//   +X     dz/|dx|     −dy/|dx|     +Z / +Y                        ( 1, −v,  u)
//   −X    −dz/|dx|     −dy/|dx|     −Z / +Y                        (−1, −v, −u)
//   +Y     dx/|dy|     −dz/|dy|     +X / +Z                        ( u,  1, −v)
//   −Y     dx/|dy|      dz/|dy|     +X / −Z                        ( u, −1,  v)
//   +Z    −dx/|dz|     −dy/|dz|     −X / +Y                        (−u, −v,  1)
//   −Z     dx/|dz|     −dy/|dz|     +X / +Y                        ( u, −v, −1)
//
// Edge pixels belong to two faces, corner pixels to three; they hold the same value. The lowest
// face index that holds a pixel owns it. For N = 1 all six faces are centres, nothing is shared.
// Source: OpenEXR's ImfEnvmap.h; docs/conventions.md.
#pragma once

#include <cstdint>
#include <optional>

#include "image/image.h"
#include "math/cube_face.h"

namespace probebake {

/// A pixel of a cubemap.
struct CubePixel {
    CubeFace face = CubeFace::kPosX;
    int x = 0;
    int y = 0;

    bool operator==(const CubePixel&) const = default;
};

/// The pixel at a place of a cubemap's image, which holds its faces one below the other.
inline CubePixel pixel_at(size_t index, int face_size_px) {
    const auto n = static_cast<size_t>(face_size_px);
    return {kCubeFaces[index / (n * n)], static_cast<int>(index % n),
            static_cast<int>(index / n % n)};
}

/// The direction (not normalised: its largest component is ±1 for |u|, |v| ≤ 1) of a point of a
/// face.
Vec3 face_direction(CubeFace face, double u, double v);

/// The face that a direction belongs to, ties X over Y over Z, and its coordinates there.
struct FacePoint {
    CubeFace face = CubeFace::kPosX;
    double u = 0.0;
    double v = 0.0;
};
FacePoint face_point(const Vec3& direction);

/// u (or v) of pixel column (row) x of a face of n pixels; exactly antisymmetric; 0 for n = 1.
inline double grid_coordinate(double x, int n) {
    return n > 1 ? (2.0 * x - (n - 1)) / (n - 1) : 2.0 * x;
}
/// Distance of neighbouring pixels in u and v.
inline double grid_spacing(int n) { return n > 1 ? 2.0 / (n - 1) : 2.0; }

/// The solid angle (sr) of what pixel (x, y) of a face of n pixels stands for: its cell of the
/// grid, clipped at the edge of the face. The same on every face; the six faces sum to 4π.
double pixel_solid_angle(int x, int y, int n);

/// The pixel that owns the value of `pixel` in a cubemap of n pixels per face.
CubePixel owner_of(const CubePixel& pixel, int n);

/// Whether a view has a pixel of its own to render: of a cubemap's face those that it owns, of any
/// other view (no face) all.
inline bool renders_pixel(const std::optional<CubeFace>& face, int x, int y, int n) {
    if (!face) return true;
    const CubePixel pixel{*face, x, y};
    return owner_of(pixel, n) == pixel;
}

/// Distinct pixels of a cubemap of n pixels per face: what is left when shared ones count once.
constexpr uint64_t owned_pixel_count(int n) {
    const auto inner = static_cast<uint64_t>(n > 2 ? n - 2 : 0);
    return n == 1 ? 6 : 6 * inner * inner + 12 * inner + 8;
}

/// Of these, those that one face owns: +X owns all of its, −X too, the others what is left.
constexpr uint64_t owned_pixel_count(CubeFace face, int n) {
    if (n == 1) return 1;
    const auto size = static_cast<uint64_t>(n);
    switch (axis_of(face)) {
        case 0:
            return size * size;
        case 1:
            return (size - 2) * size;
        default:
            return (size - 2) * (size - 2);
    }
}

/// Calls visit(pixel, owner) for every pixel that another face owns.
template <class Visit>
void for_each_shared_pixel(int n, Visit visit) {
    if (n == 1) return;
    for (const CubeFace face : kCubeFaces) {
        for (int y = 0; y < n; ++y) {
            const bool edge_row = y == 0 || y == n - 1;
            for (int x = 0; x < n; x += edge_row ? 1 : n - 1) {
                const CubePixel pixel{face, x, y};
                const CubePixel owner = owner_of(pixel, n);
                if (!(owner == pixel)) visit(pixel, owner);
            }
        }
    }
}

/// Index of a pixel in arrays that run face by face, row by row.
inline size_t cube_index(const CubePixel& p, int n) {
    const auto size = static_cast<size_t>(n);
    return (static_cast<size_t>(index_of(p.face)) * size + static_cast<size_t>(p.y)) * size +
           static_cast<size_t>(p.x);
}

class Cubemap {
  public:
    Cubemap() = default;
    explicit Cubemap(int face_size_px) : n_(face_size_px), image_(face_size_px, 6 * face_size_px) {}
    /// Adopts an image of n × 6n.
    explicit Cubemap(Image image) : n_(image.width()), image_(std::move(image)) {}

    int face_size() const { return n_; }
    Rgb& at(const CubePixel& p) { return image_.at(p.x, index_of(p.face) * n_ + p.y); }
    const Rgb& at(const CubePixel& p) const { return image_.at(p.x, index_of(p.face) * n_ + p.y); }
    const Image& image() const { return image_; }
    Image& image() { return image_; }

    /// Copies every owned pixel over the pixels that share it.
    void share_edges();

    bool operator==(const Cubemap&) const = default;

  private:
    int n_ = 0;
    Image image_;
};

/// Bilinear value in a direction of any length but zero; continuous across edges, because the faces
/// share their edge pixels.
Rgb sample_bilinear(const Cubemap& cubemap, const Vec3& direction);

}  // namespace probebake
