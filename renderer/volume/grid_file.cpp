#include "volume/grid_file.h"

#include <array>
#include <stdexcept>

#include "io/checked_file.h"

namespace probebake {
namespace {

constexpr std::string_view kKind = "density";
constexpr uint64_t kVersion = 1;

struct Place {
    IVec3 low{0};
    IVec3 cells{0};
    Affine index_to_world;
};

}  // namespace

void save_grid(const std::filesystem::path& path, const DensityGrid& grid,
               const Affine& index_to_world) {
    const std::array<Place, 1> place{{{grid.low(), grid.cells(), index_to_world}}};
    const std::array<std::span<const std::byte>, 5> sections = {
        std::as_bytes(std::span(place)), std::as_bytes(grid.table()),
        std::as_bytes(grid.constants()), std::as_bytes(grid.floats()),
        std::as_bytes(grid.halves())};
    write_checked_file(path, kKind, kVersion, sections);
}

PlacedGrid load_grid(const std::filesystem::path& path) {
    const CheckedFile file(path, kKind, kVersion);
    if (file.section_count() != 5) throw IoError(file.name(), "expected 5 sections");
    const std::vector<Place> place = file.array<Place>(0);
    if (place.size() != 1) throw IoError(file.name(), "expected one place");
    try {
        return {DensityGrid({.low = place[0].low,
                             .cells = place[0].cells,
                             .table = file.array<uint32_t>(1),
                             .constants = file.array<float>(2),
                             .floats = file.array<float>(3),
                             .halves = file.array<uint16_t>(4)}),
                place[0].index_to_world};
    } catch (const std::logic_error& error) {  // invalid_argument, length_error
        throw IoError(file.name(), error.what());
    }
}

}  // namespace probebake
