#include "bake/ddgi.h"

#include <cmath>

#include "image/octahedral.h"
#include "image/sphere_filter.h"

namespace probebake {
namespace {

/// RTXGI's default, probeDistanceExponent.
constexpr int kDistanceExponent = 50;
/// Of the diagonal of a cell of the grid, as in RTXGI.
constexpr double kMaxDistanceCells = 1.5;

/// The tile whose inside texels are value(direction).
template <class Value>
Image tile_of(int inside_px, const Value& value) {
    const int side = ddgi_tile_px(inside_px);
    Image tile(side, side);
    for (int y = 0; y < inside_px; ++y) {
        for (int x = 0; x < inside_px; ++x) {
            tile.at(x + kDdgiBorder_px, y + kDdgiBorder_px) =
                Rgb(value(octahedral_texel_direction(x, y, inside_px)));
        }
    }
    fill_octahedral_border(tile, 0, 0, inside_px);
    return tile;
}

void paste(const Image& tile, int column, int row, Image& atlas) {
    for (int y = 0; y < tile.height(); ++y) {
        for (int x = 0; x < tile.width(); ++x) {
            atlas.at(column * tile.width() + x, row * tile.height() + y) = tile.at(x, y);
        }
    }
}

}  // namespace

double ddgi_max_distance_m(const ProbeGrid& grid) {
    return kMaxDistanceCells * glm::length(grid.spacing_m);
}

DdgiTile ddgi_tile(const Cubemap& radiance, const Cubemap& distance) {
    DdgiTile tile;
    {
        const SphereFilter filter(radiance);
        tile.irradiance = tile_of(kDdgiIrradiance_px, [&](const Vec3& direction) {
            return 0.5 * filter.mean(CosineKernel{}, direction);
        });
    }
    const SphereFilter filter(distance);
    tile.distance = tile_of(kDdgiDistance_px, [&](const Vec3& direction) {
        return filter.mean(CosineKernel{kDistanceExponent}, direction);
    });
    return tile;
}

DdgiAtlas ddgi_atlas(const IVec3& counts, std::span<const DdgiTile* const> tiles) {
    const auto atlas = [&](int inside_px) {
        const int side = ddgi_tile_px(inside_px);
        return Image(counts.x * counts.y * side, counts.z * side);
    };
    DdgiAtlas out{atlas(kDdgiIrradiance_px), atlas(kDdgiDistance_px)};
    for (size_t p = 0; p < tiles.size(); ++p) {
        const int index = static_cast<int>(p);
        const int column = index % (counts.x * counts.y);
        const int row = index / (counts.x * counts.y);
        paste(tiles[p]->irradiance, column, row, out.irradiance);
        paste(tiles[p]->distance, column, row, out.distance);
    }
    return out;
}

GridResult encode_ddgi(const ProbeGrid& grid, const DdgiAtlas& atlas, ProbeAttributes about) {
    about.id = grid.id;
    about.position_m = grid.origin_m;
    about.texts["probe:grid:counts"] = attribute_text(Vec3(grid.counts));
    about.texts["probe:grid:spacing"] = attribute_text(grid.spacing_m);
    GridResult result{.grid = grid.id, .state = about.state};

    ProbeAttributes irradiance = about;
    irradiance.texts["probe:quantity"] = "irradiance / (2 pi)";
    EncodedCubemap file = encode_layout(atlas.irradiance, ExrLayout::kPlain, irradiance);
    result.is_float = file.is_float;
    result.files.push_back(make_product_file("ddgi-irradiance.exr", std::move(file.bytes)));

    about.unit = "m";
    about.texts["probe:quantity"] = "R: mean distance, G: mean of its square";
    about.numbers["probe:grid:maxDistance"] = ddgi_max_distance_m(grid);
    result.files.push_back(
        make_product_file("ddgi-distance.exr", encode_moments(atlas.distance, about)));
    return result;
}

}  // namespace probebake
