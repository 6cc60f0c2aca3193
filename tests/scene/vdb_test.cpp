// Our reading of OpenVDB files against the library's own sampler.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <cmath>
#include <limits>

#include "io/file.h"
#include "math/random.h"
#include "scene/scene_library.h"
#include "scene/vdb/vdb_file.h"
#include "support/data.h"

namespace probebake {
namespace {

class Vdb : public ::testing::Test {
  protected:
    Vdb() {
        openvdb::initialize();
        path_ =
            std::filesystem::temp_directory_path() /
            ("probebake-vdb-" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
             "-" + std::to_string(reinterpret_cast<uintptr_t>(this)) + ".vdb");
    }
    ~Vdb() override { std::filesystem::remove(path_); }

    void write(const openvdb::GridBase::Ptr& grid, const std::string& name = "density") {
        grid->setName(name);
        openvdb::io::File(path_.string()).write({grid});
    }

    std::string error(const std::string& name = "density") const {
        try {
            read_vdb_grid(path_, name);
        } catch (const IoError& e) {
            const std::string what = e.what();
            return what.substr(what.find(": ") + 2);
        }
        return "";
    }

    std::filesystem::path path_;
};

/// A blob of noise, an active tile, an inactive voxel with a value.
openvdb::FloatGrid::Ptr make_grid() {
    auto grid = openvdb::FloatGrid::create(0.0f);
    RandomStream random(1);
    for (int i = 0; i < 4000; ++i) {
        const openvdb::Coord at(static_cast<int>(random.below(30)) - 12,
                                static_cast<int>(random.below(20)) + 3,
                                static_cast<int>(random.below(25)) - 40);
        grid->tree().setValue(at, static_cast<float>(random.uniform()));
    }
    grid->tree().addTile(1, openvdb::Coord(32, 0, -8), 0.625f, true);
    grid->tree().setValueOff(openvdb::Coord(-20, 5, -30), 0.375f);
    return grid;
}

void expect_same_samples(const openvdb::FloatGrid& theirs, const VdbGrid& ours, double tolerance) {
    const openvdb::tools::GridSampler<openvdb::FloatGrid, openvdb::tools::BoxSampler> sampler(
        theirs);
    const Affine to_index = ours.index_to_world.inverse();
    openvdb::CoordBBox box = theirs.evalActiveVoxelBoundingBox();
    box.expand(4);
    RandomStream random(2);
    double sum = 0.0;
    for (int i = 0; i < 20000; ++i) {
        openvdb::Vec3d index;
        for (int a = 0; a < 3; ++a) {
            const auto k = static_cast<size_t>(a);
            index[a] = box.min()[k] + random.uniform() * (box.max()[k] - box.min()[k]);
            if (i % 4 == 0) index[a] = std::floor(index[a]);  // at voxels
        }
        const openvdb::Vec3d world = theirs.indexToWorld(index);
        const double expected = double{sampler.wsSample(world)};
        const double got = ours.grid.sample(to_index.point({world.x(), world.y(), world.z()}));
        ASSERT_NEAR(got, expected, tolerance) << i;
        // The sampler at its own index, without the way through the world: no half-voxel shift.
        ASSERT_NEAR(ours.grid.sample({index.x(), index.y(), index.z()}), expected, tolerance) << i;
        sum += expected;
    }
    EXPECT_GT(sum, 0.0);
}

TEST_F(Vdb, SamplesAreThoseOfTheLibrary) {
    const auto grid = make_grid();
    write(grid);
    const VdbGrid ours = read_vdb_grid(path_, "density");
    expect_same_samples(*grid, ours, 2e-5);
    EXPECT_EQ(ours.active_voxels, grid->activeVoxelCount());
    EXPECT_EQ(ours.active_tiles, 1u);
    EXPECT_EQ(ours.grid.sample({-20, 5, -30}), 0.375);
    EXPECT_EQ(ours.grid.sample({35.5, 3.25, -4.0}), 0.625);
}

TEST_F(Vdb, TransformsAreTheLibrarys) {
    const auto grid = make_grid();
    openvdb::math::Transform::Ptr map = openvdb::math::Transform::createLinearTransform(0.25);
    map->postRotate(0.4, openvdb::math::X_AXIS);
    map->postRotate(-1.1, openvdb::math::Z_AXIS);
    map->postScale(openvdb::Vec3d(1.0, 2.0, 0.5));
    map->postTranslate(openvdb::Vec3d(100.0, -7.0, 3.0));
    grid->setTransform(map);
    write(grid);
    expect_same_samples(*grid, read_vdb_grid(path_, "density"), 2e-5);
}

TEST_F(Vdb, HalvesDoublesAndCompression) {
    const auto grid = make_grid();
    grid->setSaveFloatAsHalf(true);
    grid->setName("density");
    openvdb::io::File half(path_.string());
    half.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    half.write({grid});
    openvdb::io::File again(path_.string());
    again.open();
    const auto read = openvdb::gridPtrCast<openvdb::FloatGrid>(again.readGrid("density"));
    const VdbGrid ours = read_vdb_grid(path_, "density");
    EXPECT_TRUE(ours.grid.is_half());
    expect_same_samples(*read, ours, 2e-5);

    const auto wide = openvdb::DoubleGrid::create(0.0);
    wide->tree().setValue(openvdb::Coord(1, 2, 3), 0.5);
    write(wide);
    EXPECT_EQ(read_vdb_grid(path_, "density").grid.sample({1, 2, 3.5}), 0.25);
}

TEST_F(Vdb, AnEmptyGridIsEmptyAir) {
    write(openvdb::FloatGrid::create(0.0f));
    const VdbGrid ours = read_vdb_grid(path_, "density");
    EXPECT_EQ(ours.active_voxels, 0u);
    EXPECT_EQ(ours.grid.stored_bricks(), 0u);
}

TEST_F(Vdb, WhatIsNoDensityIsRefusedByGridAndCount) {
    auto grid = make_grid();
    write(grid);
    EXPECT_EQ(error("smoke"), "no grid 'smoke'; the file holds 'density'");

    grid->tree().setValue(openvdb::Coord(0, 4, -30), std::numeric_limits<float>::quiet_NaN());
    grid->tree().setValue(openvdb::Coord(1, 4, -30), -2.0f);
    write(grid);
    EXPECT_EQ(error(),
              "grid 'density': 1 voxels are NaN or infinite, 1 are negative, the first at "
              "[0 4 -30]; expected finite densities, not negative");

    write(openvdb::Vec3SGrid::create());
    EXPECT_EQ(error(), "grid 'density': of type vec3s; expected float or double");

    auto far = openvdb::FloatGrid::create(0.0f);
    far->tree().setValue(openvdb::Coord(0, 0, 0), 1.0f);
    far->tree().setValue(openvdb::Coord(2'000'000'000, 0, 0), 1.0f);
    write(far);
    EXPECT_EQ(error(), "grid 'density': extent of 2000000002 voxels; expected at most 32768");

    write(openvdb::FloatGrid::create(0.5f));
    EXPECT_EQ(error(), "grid 'density': background 0.500000; expected 0");

    auto level_set = openvdb::FloatGrid::create(0.0f);
    level_set->setGridClass(openvdb::GRID_LEVEL_SET);
    write(level_set);
    EXPECT_EQ(error(), "grid 'density': a level set; expected a fog volume");
}

// A scene with a density, and temperatures to emit by.
class VdbEmission : public Vdb {
  protected:
    VdbEmission() : folder_(path_.string() + ".scene") {
        std::filesystem::create_directories(folder_);
        density_->setName("density");
        density_->tree().setValue(openvdb::Coord(1, 2, 3), 0.5f);
        temperature_->setName("temperature");
        temperature_->tree().setValue(openvdb::Coord(1, 2, 3), 2.0f);
        for (const auto& grid : {density_, temperature_}) {
            grid->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
        }
    }
    ~VdbEmission() override { std::filesystem::remove_all(folder_); }

    Media load(const std::string& fields) const {
        openvdb::io::File((folder_ / "fire.vdb").string()).write({density_, temperature_});
        write_file_atomically(folder_ / "scene.json",
                              R"({"type": "generator", "generator": "single", "size": 16, "media": [
            {"type": "vdb", "file": "fire.vdb", "absorption_per_m": [1, 1, 1],
             "emission_w_m2_sr": [3, 2, 1])" +
                                  fields + "}]}");
        return load_scene(read_scene_file(folder_ / "scene.json")).media;
    }
    std::string error_of(const std::string& fields) const {
        try {
            load(fields);
        } catch (const IoError& e) {
            return e.what();
        }
        return "";
    }

    std::filesystem::path folder_;
    openvdb::FloatGrid::Ptr density_ = openvdb::FloatGrid::create(0.0f);
    openvdb::FloatGrid::Ptr temperature_ = openvdb::FloatGrid::create(0.0f);
};

TEST_F(VdbEmission, GridsOfAnyNameMultiplyTheEmissionAndAreOptional) {
    const Media plain = load("");
    EXPECT_EQ(std::get<GridShape>(plain.all()[0].spec.shape).emission, nullptr);
    const Media media = load(R"(, "emission_grid": "temperature")");
    const auto& shape = std::get<GridShape>(media.all()[0].spec.shape);
    ASSERT_NE(shape.emission, nullptr);
    EXPECT_EQ(shape.density->sample({1, 2, 3.5}), 0.25);
    EXPECT_EQ(shape.emission->sample({1, 2, 3.5}), 1.0);
    EXPECT_EQ(media.all()[0].density(0.25 * Vec3(1, 2, 3)), 0.5);
}

TEST_F(VdbEmission, ACacheGivesTheSameMediaWithoutTheFileBeingDecoded) {
    const Media made = load(R"(, "emission_grid": "temperature")");
    const SceneFile file = read_scene_file(folder_ / "scene.json");
    EXPECT_TRUE(is_foreign(file));
    const std::filesystem::path cache = folder_ / "cache";
    EXPECT_FALSE(find_cached_scene(file, cache));
    import_scene(file, cache);
    const std::optional<Scene> scene = find_cached_scene(file, cache);
    ASSERT_TRUE(scene);
    const auto& shape = std::get<GridShape>(scene->media.all()[0].spec.shape);
    EXPECT_EQ(shape.density->sample({1, 2, 3.5}), 0.25);
    EXPECT_EQ(shape.emission->sample({1, 2, 3.5}), 1.0);
    EXPECT_EQ(scene->media.all()[0].density(0.25 * Vec3(1, 2, 3)), 0.5);
    EXPECT_EQ(scene->media.all()[0].octree.nodes(), made.all()[0].octree.nodes());

    const std::filesystem::path grid = cache / (content_sha256(file) + ".0.density");
    std::filesystem::resize_file(grid, std::filesystem::file_size(grid) - 1);
    EXPECT_FALSE(find_cached_scene(file, cache)) << "a damaged grid";
    remove_cached_scene(file, content_sha256(file), cache);
    EXPECT_TRUE(std::filesystem::is_empty(cache));
}

TEST_F(VdbEmission, WhatIsNoEmissionIsRefusedByGrid) {
    EXPECT_EQ(error_of(R"(, "emission_grid": "flames")"),
              "fire.vdb: no grid 'flames'; the file holds 'density', 'temperature'");
    temperature_->tree().setValue(openvdb::Coord(4, 4, 4), -1.0f);
    EXPECT_EQ(error_of(R"(, "emission_grid": "temperature")"),
              "fire.vdb: grid 'temperature': 0 voxels are NaN or infinite, 1 are negative, the "
              "first at [4 4 4]; expected finite densities, not negative");
    EXPECT_EQ(error_of(""), "") << "what is not asked for does not matter";
    temperature_->tree().setValue(openvdb::Coord(4, 4, 4), 1.0f);
    temperature_->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    EXPECT_EQ(
        error_of(R"(, "emission_grid": "temperature")"),
        "fire.vdb: grid 'temperature': its transform differs from that of 'density'; expected "
        "the same");
}

TEST_F(Vdb, DamagedFilesAreRefused) {
    EXPECT_EQ(error(), "no such file");
    write(make_grid());
    const auto size = std::filesystem::file_size(path_);
    for (const uintmax_t kept : {uintmax_t{0}, uintmax_t{7}, size / 4, size / 2, size - 1}) {
        std::filesystem::resize_file(path_, kept);
        EXPECT_NE(error().find("no readable OpenVDB file"), std::string::npos)
            << kept << ": " << error();
        write(make_grid());
    }
    EXPECT_EQ(vdb_grid_names(path_), std::vector<std::string>{"density"});
}

// Known answers of the manifest; tiles count as their voxels.
void expect_known(const std::string& file, uint64_t voxels, uint64_t tiles, double sum,
                  const IVec3& extent) {
    const auto path = test::data_file(file);
    if (!path) GTEST_SKIP() << file << " is not there";
    const VdbGrid ours = read_vdb_grid(*path, "density");
    EXPECT_EQ(ours.active_tiles, tiles);
    EXPECT_EQ(ours.active_voxels, voxels);
    openvdb::io::File in(path->string());
    in.open();
    const auto theirs = openvdb::gridPtrCast<openvdb::FloatGrid>(in.readGrid("density"));
    expect_same_samples(*theirs, ours, 2e-5);
    double total = 0.0;
    for (auto it = theirs->cbeginValueOn(); it; ++it) {
        const openvdb::Coord c = it.getCoord();
        total += static_cast<double>(it.getVoxelCount()) * ours.grid.sample({c.x(), c.y(), c.z()});
    }
    EXPECT_NEAR(total, sum, 1e-3);
    const openvdb::Coord dim = theirs->evalActiveVoxelDim();
    EXPECT_EQ(IVec3(dim.x(), dim.y(), dim.z()), extent);
}

TEST_F(Vdb, TheDisneyCloud) {
    expect_known("volume/wdas_cloud_sixteenth.vdb", 415642, 130, 188542.104, {126, 86, 154});
}

TEST_F(Vdb, TheDragonsTransformIsRotated) {
    expect_known("volume/dragon_with_xform.vdb", 156161, 20, 111538.403, {141, 99, 63});
}

}  // namespace
}  // namespace probebake
