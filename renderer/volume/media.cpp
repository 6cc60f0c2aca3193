#include "volume/media.h"

#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

namespace probebake {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool is_amount(const Rgb& rgb) {
    const Vec3 v(rgb);
    return is_finite(v) && v.r >= 0.0 && v.g >= 0.0 && v.b >= 0.0;
}

[[noreturn]] void refuse(const MediumSpec& spec, const std::string& what) {
    throw std::invalid_argument("medium '" + spec.name + "': " + what);
}

void check_box(const MediumSpec& spec, const std::optional<Box>& box) {
    if (!box) return;
    if (!is_finite(box->low) || !is_finite(box->high) ||
        !glm::all(glm::lessThan(box->low, box->high))) {
        refuse(spec, "the box must be finite, its low corner below its high one");
    }
}

void check_shape(const MediumSpec& spec, const HomogeneousShape& shape) {
    check_box(spec, shape.box_m);
}

void check_shape(const MediumSpec& spec, const FogShape& shape) {
    check_box(spec, shape.box_m);
    if (!std::isfinite(shape.base_m)) refuse(spec, "base_m must be finite");
    if (!(shape.scale_height_m > 0.0) || !std::isfinite(shape.scale_height_m)) {
        refuse(spec, "scale_height_m must be positive and finite");
    }
}

void check_shape(const MediumSpec& spec, const GridShape& shape) {
    if (shape.density == nullptr) refuse(spec, "no density grid");
    const double determinant = glm::determinant(shape.index_to_world.linear);
    if (!std::isnormal(determinant) || !is_finite(shape.index_to_world.offset)) {
        refuse(spec, "its index-to-world map cannot be inverted");
    }
}

Box box_of(const HomogeneousShape& shape) {
    return shape.box_m.value_or(Box{Vec3(-kInfinity), Vec3(kInfinity)});
}

Box box_of(const FogShape& shape) {
    Box box = shape.box_m.value_or(Box{Vec3(-kInfinity), Vec3(kInfinity)});
    box.high.y = std::min(box.high.y, shape.base_m + kFogScaleHeights * shape.scale_height_m);
    return box;
}

Box box_of(const GridShape& shape) {
    Box box{Vec3(kInfinity), Vec3(-kInfinity)};
    const Vec3 low(shape.density->low());
    const Vec3 size(shape.density->cells());
    for (int i = 0; i < 8; ++i) {
        const Vec3 corner =
            shape.index_to_world.point(low + size * Vec3(i & 1, i >> 1 & 1, i >> 2));
        box.low = glm::min(box.low, corner);
        box.high = glm::max(box.high, corner);
    }
    return box;
}

double fog_density(const FogShape& fog, double y) {
    return std::exp(-std::max(0.0, y - fog.base_m) / fog.scale_height_m);
}

/// ∫ from begin to end of exp(−max(0, y − base) / height), y along the ray.
double fog_column(const FogShape& fog, const Ray& ray, const TRange& range) {
    const double dy = ray.direction.y;
    const double height = fog.scale_height_m;
    const auto piece = [&](double begin, double end) {
        if (!(begin < end)) return 0.0;
        const double y0 = ray.origin.y + dy * begin - fog.base_m;
        // Above or below by the middle: at the base itself rounding would decide.
        if (ray.origin.y + dy * 0.5 * (begin + end) <= fog.base_m) return end - begin;
        const double x = -dy / height * (end - begin);
        const double mean = std::abs(x) < 1e-12 ? 1.0 : std::expm1(x) / x;
        return std::exp(-std::max(0.0, y0) / height) * mean * (end - begin);
    };
    const double at_base = (fog.base_m - ray.origin.y) / dy;
    const double split = std::clamp(at_base, range.begin, range.end);
    return piece(range.begin, split) + piece(split, range.end);
}

}  // namespace

void check_medium(const MediumSpec& spec) {
    if (!is_amount(spec.absorption_per_m)) {
        refuse(spec, "absorption_per_m must be finite and not negative");
    }
    if (!is_amount(spec.scattering_per_m)) {
        refuse(spec, "scattering_per_m must be finite and not negative");
    }
    if (!is_amount(spec.emission)) refuse(spec, "emission must be finite and not negative");
    for (int c = 0; c < 3; ++c) {
        if (spec.emission[c] > 0.0f && !(spec.absorption_per_m[c] > 0.0f)) {
            refuse(spec,
                   "emission needs absorption in the same channel: a metre emits "
                   "absorption_per_m × emission");
        }
    }
    if (!(std::abs(spec.g) < 1.0)) refuse(spec, "g must lie between -1 and 1, ends excluded");
    std::visit([&](const auto& shape) { check_shape(spec, shape); }, spec.shape);
}

double Medium::density(const Vec3& position_m) const {
    if (const auto* grid = std::get_if<GridShape>(&spec.shape)) {
        return grid->density->sample(world_to_index.point(position_m));
    }
    if (!box.contains(position_m)) return 0.0;
    const auto* fog = std::get_if<FogShape>(&spec.shape);
    return fog != nullptr ? fog_density(*fog, position_m.y) : 1.0;
}

double Medium::emission_scale(const Vec3& position_m) const {
    const auto* grid = std::get_if<GridShape>(&spec.shape);
    if (grid == nullptr || grid->emission == nullptr) return 1.0;
    return grid->emission->sample(world_to_index.point(position_m));
}

double Medium::column(const Ray& ray_m, const TRange& range) const {
    if (const auto* grid = std::get_if<GridShape>(&spec.shape)) {
        return grid_column(
            *grid->density,
            {world_to_index.point(ray_m.origin), world_to_index.vector(ray_m.direction)}, range);
    }
    const Ray ray{ray_m.origin, safe_direction(ray_m.direction)};
    const auto inside = clip(box, ray, range);
    if (!inside) return 0.0;
    const auto* fog = std::get_if<FogShape>(&spec.shape);
    return fog != nullptr ? fog_column(*fog, ray, *inside) : inside->end - inside->begin;
}

Media::Media(std::vector<MediumSpec> specs, const MajorantParams& params) {
    if (specs.size() > kMaxMedia) {
        throw std::length_error(std::to_string(specs.size()) + " media; expected at most " +
                                std::to_string(kMaxMedia));
    }
    for (MediumSpec& spec : specs) {
        check_medium(spec);
        Medium medium;
        medium.unit = {to_spectrum(spec.absorption_per_m), to_spectrum(spec.scattering_per_m)};
        const double extinction = medium.unit.extinction().max();
        if (!(extinction > 0.0)) continue;
        medium.source = to_spectrum(spec.emission);
        medium.box = std::visit([](const auto& shape) { return box_of(shape); }, spec.shape);
        if (const auto* grid = std::get_if<GridShape>(&spec.shape)) {
            MajorantParams own = params;
            own.scale =
                extinction * std::cbrt(std::abs(glm::determinant(grid->index_to_world.linear)));
            medium.octree = MajorantOctree(*grid->density, own);
            medium.world_to_index = grid->index_to_world.inverse();
            medium.world_to_units = medium.octree.index_to_units().after(medium.world_to_index);
        }
        medium.spec = std::move(spec);
        media_.push_back(std::move(medium));
    }
}

Coefficients<3> Media::at(const Vec3& position_m) const {
    Coefficients<3> sum;
    for (const Medium& medium : media_) sum += medium.unit * medium.density(position_m);
    return sum;
}

Spectrum<3> Media::emitted_per_m(const Vec3& position_m) const {
    Spectrum<3> sum;
    for (const Medium& medium : media_) {
        sum += medium.unit.absorption * medium.source *
               (medium.density(position_m) * medium.emission_scale(position_m));
    }
    return sum;
}

Spectrum<3> Media::optical_depth(const Ray& ray_m, const TRange& range) const {
    Spectrum<3> sum;
    for (const Medium& medium : media_) {
        sum += medium.unit.extinction() * medium.column(ray_m, range);
    }
    return sum;
}

uint64_t Media::memory_bytes() const {
    std::set<const DensityGrid*> grids;
    uint64_t bytes = 0;
    for (const Medium& medium : media_) {
        bytes += medium.octree.memory_bytes();
        if (const auto* shape = std::get_if<GridShape>(&medium.spec.shape)) {
            grids.insert(shape->density.get());
            grids.insert(shape->emission.get());
        }
    }
    for (const DensityGrid* grid : grids) bytes += grid != nullptr ? grid->memory_bytes() : 0;
    return bytes;
}

double grid_column(const DensityGrid& grid, const Ray& ray, const TRange& range) {
    const Vec3 direction = safe_direction(ray.direction);
    const Vec3 low(grid.low());
    const auto inside = clip({low, low + Vec3(grid.cells())}, {ray.origin, direction}, range);
    if (!inside) return 0.0;
    const Vec3 inverse = 1.0 / direction;
    const Vec3 entry = ray.origin + direction * inside->begin - low;
    IVec3 cell(0);
    for (int a = 0; a < 3; ++a) {
        cell[a] =
            static_cast<int>(std::clamp(entry[a], 0.0, static_cast<double>(grid.cells()[a]) - 0.5));
    }
    double sum = 0.0;
    double t = inside->begin;
    while (t < inside->end) {
        int axis = 0;
        double exit = kInfinity;
        for (int a = 0; a < 3; ++a) {
            const double plane = low[a] + cell[a] + (direction[a] > 0.0 ? 1.0 : 0.0);
            const double at = (plane - ray.origin[a]) * inverse[a];
            if (at < exit) {
                exit = at;
                axis = a;
            }
        }
        const double end = std::min(std::max(exit, t), inside->end);
        // Along a line a trilinear cell is a cubic, which two Gauss points integrate exactly.
        constexpr double kGauss = 0.28867513459481287;
        const double middle = 0.5 * (t + end);
        const double length = end - t;
        sum += 0.5 * length *
               (grid.sample(ray.origin + direction * (middle - kGauss * length)) +
                grid.sample(ray.origin + direction * (middle + kGauss * length)));
        t = std::max(exit, t);
        cell[axis] += direction[axis] > 0.0 ? 1 : -1;
        if (cell[axis] < 0 || cell[axis] >= grid.cells()[axis]) break;
    }
    return sum;
}

}  // namespace probebake
