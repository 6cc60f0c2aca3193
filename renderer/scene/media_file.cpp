#include "scene/media_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scene/scene_library.h"
#include "scene/vdb/vdb_file.h"
#include "volume/grid_file.h"

namespace probebake {
namespace {

constexpr double kMaxPerMetre = 1e6;
constexpr double kMaxEmission = 1e9;
constexpr double kMaxPosition_m = 1e6;
constexpr std::string_view kTypes[] = {"homogeneous", "fog", "vdb", "cumulus"};

/// Three numbers, none of them negative; 0 where absent.
Rgb read_amount(ObjectReader& reader, std::string_view key, double most) {
    const Vec3 amount = reader.vector(key, most, Vec3(0.0));
    for (int c = 0; c < 3; ++c) {
        if (!(amount[c] >= 0.0)) {
            reader.issues().unacceptable(reader.pointer_to(key) + "/" + std::to_string(c),
                                         "expected no negative number");
        }
    }
    return Rgb(amount);
}

std::optional<Box> read_box(ObjectReader& reader) {
    const bool there = reader.has("box_m");
    ObjectReader box_reader = reader.object("box_m");
    if (!there) return std::nullopt;
    const Box box{box_reader.vector("low", kMaxPosition_m, std::nullopt),
                  box_reader.vector("high", kMaxPosition_m, std::nullopt)};
    box_reader.refuse_unknown();
    for (int axis = 0; axis < 3; ++axis) {
        if (!(box.low[axis] < box.high[axis])) {
            reader.issues().unacceptable(box_reader.pointer_to("high") + "/" + std::to_string(axis),
                                         "expected more than the low corner");
        }
    }
    return box;
}

FogShape read_fog(ObjectReader& reader) {
    FogShape fog;
    fog.base_m = reader.number("base_m", {-kMaxPosition_m, kMaxPosition_m}, fog.base_m);
    fog.scale_height_m = reader.number(
        "scale_height_m", {.min = 0.0, .max = kMaxPosition_m, .more_than_min = true}, std::nullopt);
    fog.box_m = read_box(reader);
    return fog;
}

VdbMediumFile read_vdb(ObjectReader& reader, const std::filesystem::path& folder) {
    VdbMediumFile vdb;
    const std::string file = reader.string("file", 64, std::nullopt);
    if (!is_file_name(file)) {
        reader.issues().unacceptable(reader.pointer_to("file"),
                                     "expected the name of a file in the scene's own folder");
    }
    vdb.path = folder / file;
    vdb.grid = reader.string("grid", 256, "density");
    if (reader.has("emission_grid")) {
        vdb.emission_grid = reader.string("emission_grid", 256, std::nullopt);
    }
    return vdb;
}

Affine read_place(ObjectReader& reader, double scale) {
    const double turn =
        reader.number("rotation_deg", {-360.0, 360.0}, 0.0) * std::numbers::pi / 180.0;
    Affine place;
    const double c = std::cos(turn) * scale;
    const double s = std::sin(turn) * scale;
    // From +Z towards +X, as skies turn.
    place.linear = glm::dmat3(Vec3(c, 0.0, -s), Vec3(0.0, scale, 0.0), Vec3(s, 0.0, c));
    place.offset = reader.vector("origin_m", kMaxPosition_m, Vec3(0.0));
    return place;
}

MediumFile read_medium(ObjectReader& reader, const std::filesystem::path& folder) {
    MediumFile file;
    MediumSpec& spec = file.spec;
    const size_t type = reader.choice("type", kTypes, std::nullopt);
    spec.name = reader.name("name", std::string(kTypes[type]));
    spec.absorption_per_m = read_amount(reader, "absorption_per_m", kMaxPerMetre);
    spec.scattering_per_m = read_amount(reader, "scattering_per_m", kMaxPerMetre);
    spec.emission = read_amount(reader, "emission_w_m2_sr", kMaxEmission);
    for (int c = 0; c < 3; ++c) {
        if (spec.emission[c] > 0.0f && !(spec.absorption_per_m[c] > 0.0f)) {
            reader.issues().unacceptable(
                reader.pointer_to("emission_w_m2_sr") + "/" + std::to_string(c),
                "expected absorption in the same channel: a metre of medium emits absorption × "
                "emission");
        }
    }
    const Rgb extinction = spec.absorption_per_m + spec.scattering_per_m;
    if (!(std::max({extinction.r, extinction.g, extinction.b}) > 0.0f)) {
        reader.issues().unacceptable(reader.pointer_to("scattering_per_m"),
                                     "expected a medium that scatters or absorbs");
    }
    spec.g = reader.number("g", {-0.999, 0.999}, spec.g);
    switch (type) {
        case 0:
            spec.shape = HomogeneousShape{read_box(reader)};
            break;
        case 1:
            spec.shape = read_fog(reader);
            break;
        case 2:
            file.vdb = read_vdb(reader, folder);
            file.place = read_place(reader, reader.number("scale", {1e-6, 1e6}, 1.0));
            break;
        default: {
            CumulusParams cumulus;
            cumulus.size = static_cast<int>(reader.integer("size", 16, 2048, 256));
            cumulus.seed =
                reader.unsigned_integer("seed", std::numeric_limits<uint64_t>::max(), cumulus.seed);
            const double width_m = reader.number("width_m", {1e-3, kMaxPosition_m}, std::nullopt);
            file.place = read_place(reader, width_m / cumulus.size);
            file.cumulus = cumulus;
        }
    }
    reader.refuse_unknown();
    return file;
}

GridShape load_vdb(const VdbMediumFile& file) {
    GridShape shape;
    VdbGrid density = read_vdb_grid(file.path, file.grid);
    shape.index_to_world = density.index_to_world;
    shape.density = std::make_shared<DensityGrid>(std::move(density.grid));
    if (!file.emission_grid) return shape;
    VdbGrid emission = read_vdb_grid(file.path, *file.emission_grid);
    if (emission.index_to_world.linear != shape.index_to_world.linear ||
        emission.index_to_world.offset != shape.index_to_world.offset) {
        throw IoError(file.path.filename().string(), "grid '" + *file.emission_grid +
                                                         "': its transform differs from that of '" +
                                                         file.grid + "'; expected the same");
    }
    shape.emission = std::make_shared<DensityGrid>(std::move(emission.grid));
    return shape;
}

struct GridNames {
    GridNames(const std::filesystem::path& stem, size_t medium)
        : density(stem.string() + "." + std::to_string(medium) + ".density"),
          emission(stem.string() + "." + std::to_string(medium) + ".emission") {}

    std::filesystem::path density;
    std::filesystem::path emission;
};

bool has_grid(const MediumFile& file) { return file.vdb || file.cumulus; }

/// Decodes or generates it, in its own space.
GridShape make_grid(const MediumFile& file) {
    if (file.vdb) return load_vdb(*file.vdb);
    GridShape shape;
    shape.density = std::make_shared<DensityGrid>(make_cumulus(*file.cumulus));
    return shape;
}

GridShape load_cached(const MediumFile& file, const GridNames& names) {
    GridShape shape;
    PlacedGrid density = load_grid(names.density);
    shape.index_to_world = density.index_to_world;
    shape.density = std::make_shared<DensityGrid>(std::move(density.grid));
    if (file.vdb && file.vdb->emission_grid) {
        shape.emission = std::make_shared<DensityGrid>(load_grid(names.emission).grid);
    }
    return shape;
}

}  // namespace

std::vector<MediumFile> read_media(ObjectReader& scene, const std::filesystem::path& folder) {
    std::vector<MediumFile> media;
    for (const auto& [value, pointer] : scene.array("media", kMaxMedia)) {
        ObjectReader reader(*value, pointer, scene.issues());
        media.push_back(read_medium(reader, folder));
    }
    return media;
}

void cache_grids(const std::vector<MediumFile>& files, const std::filesystem::path& stem) {
    for (size_t i = 0; i < files.size(); ++i) {
        if (!has_grid(files[i])) continue;
        const GridShape shape = make_grid(files[i]);
        const GridNames names(stem, i);
        save_grid(names.density, *shape.density, shape.index_to_world);
        if (shape.emission) save_grid(names.emission, *shape.emission, shape.index_to_world);
    }
}

bool has_grid_files(const std::vector<MediumFile>& files) {
    return std::any_of(files.begin(), files.end(),
                       [](const MediumFile& file) { return file.vdb.has_value(); });
}

void remove_cached_grids(const std::vector<MediumFile>& files, const std::filesystem::path& stem) {
    for (size_t i = 0; i < files.size(); ++i) {
        const GridNames names(stem, i);
        std::error_code error;
        std::filesystem::remove(names.density, error);
        std::filesystem::remove(names.emission, error);
    }
}

Media load_media(const std::vector<MediumFile>& files,
                 const std::optional<std::filesystem::path>& stem) {
    std::vector<MediumSpec> specs;
    for (size_t i = 0; i < files.size(); ++i) {
        const MediumFile& file = files[i];
        specs.push_back(file.spec);
        if (!has_grid(file)) continue;
        GridShape shape = stem ? load_cached(file, GridNames(*stem, i)) : make_grid(file);
        shape.index_to_world = file.place.after(shape.index_to_world);
        specs.back().shape = std::move(shape);
    }
    return Media(std::move(specs));
}

Box extent_of(const Media& media) {
    Box extent = media.all().front().box;
    for (const Medium& medium : media.all()) {
        extent.low = glm::min(extent.low, medium.box.low);
        extent.high = glm::max(extent.high, medium.box.high);
    }
    return extent;
}

}  // namespace probebake
