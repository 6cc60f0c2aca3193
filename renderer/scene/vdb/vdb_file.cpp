// The only file that includes OpenVDB, besides a study's and the tests'.
#include "scene/vdb/vdb_file.h"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <fstream>
#include <unordered_set>

namespace probebake {
namespace {

std::string name_of(const std::filesystem::path& path) { return path.filename().string(); }

/// All grids of a file. Read as a stream that throws: the library's own File takes what lies behind
/// the end of a truncated file for values.
openvdb::GridPtrVec read_all(const std::filesystem::path& path) {
    if (!std::filesystem::is_regular_file(path)) throw IoError(name_of(path), "no such file");
    openvdb::initialize();
    try {
        std::ifstream in(path, std::ios::binary);
        in.exceptions(std::ios::failbit | std::ios::badbit);
        return *openvdb::io::Stream(in, /*delayLoad=*/false).getGrids();
    } catch (const std::exception& error) {
        throw IoError(name_of(path), std::string("no readable OpenVDB file: ") + error.what());
    }
}

IVec3 to_ivec3(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

uint64_t brick_key(const IVec3& brick) {
    return static_cast<uint64_t>(brick.x) | static_cast<uint64_t>(brick.y) << 20 |
           static_cast<uint64_t>(brick.z) << 40;
}

Affine affine_of(const openvdb::math::Transform& transform) {
    const openvdb::Mat4d m = transform.baseMap()->getAffineMap()->getMat4();  // rows are images
    Affine affine;
    for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row) affine.linear[column][row] = m(column, row);
    }
    affine.offset = {m(3, 0), m(3, 1), m(3, 2)};
    return affine;
}

template <class VdbTree>
class Converter {
  public:
    using Value = typename VdbTree::ValueType;

    explicit Converter(const VdbTree& tree) : tree_(tree) {}

    DensityGrid run() const {
        if (tree_.background() != Value(0)) {
            throw std::runtime_error("background " + std::to_string(tree_.background()) +
                                     "; expected 0");
        }
        const openvdb::CoordBBox box = extent();
        DensityGrid::BuildParams params;
        // The field reaches one cell beyond the outermost voxels.
        const openvdb::Coord low = box.min().offsetBy(-1);
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<size_t>(axis);
            const int64_t cells = int64_t{box.max()[a]} - low[a] + 1;
            if (cells > DensityGrid::kMaxCells) {
                throw std::length_error("extent of " + std::to_string(cells) +
                                        " voxels; expected at most " +
                                        std::to_string(DensityGrid::kMaxCells));
            }
            params.cells[axis] = static_cast<int>(cells);
        }
        params.low = to_ivec3(low);
        DensityGrid::check_extent(params);
        const std::unordered_set<uint64_t> used = used_bricks(params);
        return DensityGrid(params, [&](const IVec3& brick_low, DensityGrid::BrickValues values) {
            if (used.count(brick_key((brick_low - params.low) / DensityGrid::kBrick)) == 0) {
                return false;
            }
            const openvdb::tree::ValueAccessor<const VdbTree> accessor(tree_);
            size_t i = 0;
            for (int z = 0; z < DensityGrid::kSide; ++z) {
                for (int y = 0; y < DensityGrid::kSide; ++y) {
                    for (int x = 0; x < DensityGrid::kSide; ++x) {
                        const openvdb::Coord at(brick_low.x + x, brick_low.y + y, brick_low.z + z);
                        values[i++] = static_cast<float>(accessor.getValue(at));
                    }
                }
            }
            return true;
        });
    }

  private:
    /// Of everything that is not the background, active or not.
    openvdb::CoordBBox extent() const {
        openvdb::CoordBBox box;
        for_each_region([&](const openvdb::CoordBBox& region) { box.expand(region); });
        if (box.empty()) box = openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(0));
        return box;
    }

    template <class Visit>
    void for_each_region(Visit visit) const {
        for (auto leaf = tree_.cbeginLeaf(); leaf; ++leaf) {
            openvdb::CoordBBox box;
            for (auto value = leaf->cbeginValueAll(); value; ++value) {
                if (*value != Value(0)) box.expand(value.getCoord());
            }
            if (!box.empty()) visit(box);
        }
        auto tile = tree_.cbeginValueAll();
        tile.setMaxDepth(VdbTree::ValueAllCIter::LEAF_DEPTH - 1);
        for (; tile; ++tile) {
            if (*tile == Value(0)) continue;
            openvdb::CoordBBox box;
            tile.getBoundingBox(box);
            visit(box);
        }
    }

    std::unordered_set<uint64_t> used_bricks(const DensityGrid::BuildParams& params) const {
        std::unordered_set<uint64_t> used;
        for_each_region([&](const openvdb::CoordBBox& region) {
            // A voxel is a corner of the cells on both its sides.
            const IVec3 first = (to_ivec3(region.min()) - 1 - params.low) / DensityGrid::kBrick;
            const IVec3 last = (to_ivec3(region.max()) - params.low) / DensityGrid::kBrick;
            for (int z = first.z; z <= last.z; ++z) {
                for (int y = first.y; y <= last.y; ++y) {
                    for (int x = first.x; x <= last.x; ++x) used.insert(brick_key({x, y, z}));
                }
            }
        });
        return used;
    }

    const VdbTree& tree_;
};

template <class Grid>
VdbGrid convert(const Grid& grid) {
    if (grid.getGridClass() == openvdb::GRID_LEVEL_SET) {
        throw std::runtime_error("a level set; expected a fog volume");
    }
    if (!grid.transform().isLinear()) {
        throw std::runtime_error("a perspective transform; expected an affine one");
    }
    VdbGrid out;
    out.index_to_world = affine_of(grid.transform());
    const Affine& map = out.index_to_world;
    if (!std::isnormal(glm::determinant(map.linear)) || !is_finite(map.offset)) {
        throw std::runtime_error("a transform that is not finite or cannot be inverted");
    }
    out.active_voxels = grid.activeVoxelCount();
    out.active_tiles = grid.tree().activeTileCount();
    out.grid = Converter<typename Grid::TreeType>(grid.tree()).run();
    return out;
}

}  // namespace

bool reads_vdb() { return true; }

VdbGrid read_vdb_grid(const std::filesystem::path& path, const std::string& grid_name) {
    openvdb::GridBase::Ptr base;
    std::string list;
    for (const openvdb::GridBase::Ptr& grid : read_all(path)) {
        if (!base && grid->getName() == grid_name) base = grid;
        list += (list.empty() ? "'" : ", '") + grid->getName() + "'";
    }
    if (!base) {
        throw IoError(name_of(path), "no grid '" + grid_name + "'; the file holds " +
                                         (list.empty() ? "none" : list));
    }
    const std::string what = "grid '" + grid_name + "': ";
    try {
        if (const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(base)) {
            return convert(*grid);
        }
        if (const auto grid = openvdb::gridPtrCast<openvdb::DoubleGrid>(base)) {
            return convert(*grid);
        }
    } catch (const std::exception& error) {
        throw IoError(name_of(path), what + error.what());
    }
    throw IoError(name_of(path),
                  what + "of type " + base->valueType() + "; expected float or double");
}

std::vector<std::string> vdb_grid_names(const std::filesystem::path& path) {
    std::vector<std::string> names;
    for (const openvdb::GridBase::Ptr& grid : read_all(path)) names.push_back(grid->getName());
    return names;
}

}  // namespace probebake
