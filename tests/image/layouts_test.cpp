// Latlong and GL faces: by their definitions here, by other programs below.
#include "image/layouts.h"

#include <ImfEnvmap.h>
#include <ImfRgbaFile.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "image/cubemaps.h"
#include "image/exr.h"
#include "image/tools.h"
#include "io/file.h"

namespace probebake {
namespace {

using test::run_tool;

#define SKIP_WITHOUT(tool) \
    if (!test::has_tool(tool)) GTEST_SKIP() << (tool) << " is not installed"

double degrees_between(const Vec3& a, const Vec3& b) {
    const double chord = glm::length(glm::normalize(a) - glm::normalize(b));
    return 2.0 * std::asin(std::min(chord / 2.0, 1.0)) * 180.0 / std::numbers::pi;
}
/// The direction that a pixel of a direction-coded image holds.
Vec3 coded(const Rgb& value) { return 2.0 * Vec3(value) - 1.0; }

/// Where a texel of a GL face lies, from the wording of the specification: (s_c, t_c, m_a) by face.
Vec3 specified_direction(size_t face, double s, double t) {
    switch (face) {
        case 0:
            return {1, -t, -s};  // s_c = −r_z, t_c = −r_y
        case 1:
            return {-1, -t, s};  // s_c = r_z, t_c = −r_y
        case 2:
            return {s, 1, t};  // s_c = r_x, t_c = r_z
        case 3:
            return {s, -1, -t};  // s_c = r_x, t_c = −r_z
        case 4:
            return {s, -t, 1};  // s_c = r_x, t_c = −r_y
        default:
            return {-s, -t, -1};  // s_c = −r_x, t_c = −r_y
    }
}

// Bilinear interpolation between pixels shortens directions, and unevenly on coarse grids; a mean
// over a wide cell turns them a little, too. A latlong flipped or half a pixel off is far outside.
TEST(Layouts, EveryDirectionIsWhereItBelongs) {
    for (const auto& [n, tolerance] :
         {std::pair{4, 2.5}, std::pair{16, 0.15}, std::pair{64, 0.008}, std::pair{512, 3e-4}}) {
        const Cubemap cube = test::direction_cubemap(n);
        const Image latlong = latlong_of(cube);
        ASSERT_EQ(latlong.width(), 4 * n);
        ASSERT_EQ(latlong.height(), 2 * n);
        const Imath::Box2i window({0, 0}, {latlong.width() - 1, latlong.height() - 1});
        double largest = 0.0;
        for (int y = 0; y < latlong.height(); ++y) {
            for (int x = 0; x < latlong.width(); ++x) {
                const Imath::V3f d = Imf::LatLongMap::direction(
                    window, {static_cast<float>(x), static_cast<float>(y)});
                largest = std::max(largest,
                                   degrees_between(coded(latlong.at(x, y)), Vec3(d.x, d.y, d.z)));
            }
        }
        double largest_gl = 0.0;
        for (const CubeFace face : kCubeFaces) {
            const Image image = gl_face_of(cube, face);
            ASSERT_EQ(image.width(), n);
            for (int y = 0; y < n; ++y) {
                for (int x = 0; x < n; ++x) {
                    const Vec3 d =
                        specified_direction(static_cast<size_t>(index_of(face)),
                                            (x + 0.5) * 2.0 / n - 1.0, (y + 0.5) * 2.0 / n - 1.0);
                    largest_gl = std::max(largest_gl, degrees_between(coded(image.at(x, y)), d));
                }
            }
        }
        std::printf("N = %d: latlong off by %.4f, GL faces by %.4f degrees at most\n", n, largest,
                    largest_gl);
        EXPECT_LT(largest, tolerance);
        EXPECT_LT(largest_gl, tolerance);
    }
}

/// Σ value · solid angle of an OpenEXR latlong, its edge pixels clipped.
double latlong_integral(const Image& image) {
    const double step = std::numbers::pi / (image.height() - 1);
    double sum = 0.0;
    for (int y = 0; y < image.height(); ++y) {
        const double top = std::max(step * (y - 0.5), 0.0);
        const double bottom = std::min(step * (y + 0.5), std::numbers::pi);
        const double band = (std::cos(top) - std::cos(bottom)) * 2.0 * std::numbers::pi;
        for (int x = 0; x + 1 < image.width(); ++x) {
            sum += static_cast<double>(image.at(x, y).g) * band / (image.width() - 1);
        }
    }
    return sum;
}

double gl_integral(const Cubemap& cube) {
    double sum = 0.0;
    const int n = cube.face_size();
    const auto corner = [](double u, double v) {
        return std::atan2(u * v, std::sqrt(u * u + v * v + 1.0));
    };
    for (const CubeFace face : kCubeFaces) {
        const Image image = gl_face_of(cube, face);
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) {
                const double u = 2.0 * x / n - 1.0;
                const double v = 2.0 * y / n - 1.0;
                const double w = 2.0 / n;
                sum += static_cast<double>(image.at(x, y).g) *
                       (corner(u + w, v + w) - corner(u, v + w) - corner(u + w, v) + corner(u, v));
            }
        }
    }
    return sum;
}

// A single pixel of 1e6 is as much light on every grid, wherever it lies, within what a grid of
// other pixels can say of it.
TEST(Layouts, ABrightPixelKeepsItsLight) {
    for (const int n : {4, 16, 64}) {
        for (const CubePixel at :
             {CubePixel{CubeFace::kPosX, n / 2, n / 2}, CubePixel{CubeFace::kPosY, 1, 1},
              CubePixel{CubeFace::kNegZ, n - 2, n / 3}}) {
            Cubemap cube(n);
            cube.at(at) = Rgb(1e6f);
            const double expected = 1e6 * pixel_solid_angle(at.x, at.y, n);
            const Image latlong = latlong_of(cube);
            EXPECT_NEAR(latlong_integral(latlong) / expected, 1.0, 0.25) << n << " " << at.x;
            EXPECT_NEAR(gl_integral(cube) / expected, 1.0, 0.45) << n << " " << at.x;
            EXPECT_TRUE(encode_layout(latlong, ExrLayout::kLatlong, {}).is_float) << n;
        }
    }
    const Image dim = latlong_of(test::direction_cubemap(16));
    EXPECT_FALSE(encode_layout(dim, ExrLayout::kLatlong, {}).is_float);
    EXPECT_EQ(
        encode_layout(dim, ExrLayout::kLatlong, {}).bytes,
        encode_layout(latlong_of(test::direction_cubemap(16)), ExrLayout::kLatlong, {}).bytes);
    Image bad = dim;
    bad.at(3, 3).g = -1.0f;
    EXPECT_THROW(encode_layout(bad, ExrLayout::kPlain, {}), std::domain_error);
    bad.at(3, 3).g = std::nanf("");
    EXPECT_THROW(encode_layout(bad, ExrLayout::kPlain, {}), std::domain_error);
}

class LayoutTools : public testing::Test {
  protected:
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    void write(const std::string& name, const Image& image, ExrLayout layout) const {
        write_file_atomically(path(name), encode_layout(image, layout, {}).bytes);
    }
    static bool contains(const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    }
    /// Any RGB file, HALF or FLOAT, at HALF precision.
    Image read(const std::string& name) const {
        Imf::RgbaInputFile file(path(name).c_str());
        const Imath::Box2i window = file.dataWindow();
        Image image(window.max.x + 1, window.max.y + 1);
        std::vector<Imf::Rgba> values(image.pixels().size());
        file.setFrameBuffer(values.data(), 1, static_cast<size_t>(image.width()));
        file.readPixels(0, window.max.y);
        for (size_t i = 0; i < values.size(); ++i) {
            image.pixels()[i] = Rgb(values[i].r, values[i].g, values[i].b);
        }
        return image;
    }

    test::TemporaryFolder folder_;
};

TEST_F(LayoutTools, ReadersRecogniseTheFiles) {
    SKIP_WITHOUT("exrheader");
    SKIP_WITHOUT("iinfo");
    for (const int n : {4, 16, 64, 512}) {
        for (const bool bright : {false, true}) {
            Cubemap cube = test::direction_cubemap(n);
            if (bright) cube.at({CubeFace::kPosX, n / 2, n / 2}) = Rgb(1e6f);
            write("latlong.exr", latlong_of(cube), ExrLayout::kLatlong);
            write("px.exr", gl_face_of(cube, CubeFace::kPosX), ExrLayout::kPlain);
            const char* type = bright ? "R, 32-bit floating-point" : "R, 16-bit floating-point";
            const std::string latlong = run_tool("exrheader " + path("latlong.exr")).text;
            EXPECT_TRUE(contains(latlong, "latitude-longitude map")) << latlong;
            EXPECT_TRUE(contains(latlong, type)) << latlong;
            const std::string face = run_tool("exrheader " + path("px.exr")).text;
            EXPECT_FALSE(contains(face, "envmap")) << face;
            EXPECT_TRUE(contains(face, type)) << face;
            const std::string info = run_tool("iinfo -v " + path("latlong.exr")).text;
            EXPECT_TRUE(contains(info, "LatLong Environment")) << info;
        }
    }
}

// exrenvmap makes a cubemap of the latlong again: the same within its own interpolation.
TEST_F(LayoutTools, ExrenvmapTurnsTheLatlongBackIntoTheCube) {
    SKIP_WITHOUT("exrenvmap");
    for (const auto& [n, tolerance] : {std::pair{16, 0.2}, std::pair{64, 0.1}}) {
        write("latlong.exr", latlong_of(test::direction_cubemap(n)), ExrLayout::kLatlong);
        const auto run = run_tool("exrenvmap -c -w " + std::to_string(n) + " " +
                                  path("latlong.exr") + " " + path("cube.exr"));
        ASSERT_EQ(run.status, 0) << run.text;
        const Image back = read("cube.exr");
        ASSERT_EQ(back.height(), 6 * n);
        double largest = 0.0;
        for (size_t i = 0; i < back.pixels().size(); ++i) {
            largest = std::max(largest, degrees_between(coded(back.pixels()[i]),
                                                        test::pixel_direction(pixel_at(i, n), n)));
        }
        std::printf("N = %d: back from the latlong within %.3f degrees\n", n, largest);
        EXPECT_LT(largest, tolerance);
    }
}

// Seen from inside, OpenEXR's faces are mirrored sideways (±X, ±Z) or upside down (±Y) against
// GL's. oiiotool turns them, exrenvmap puts them together and makes a latlong: every direction is
// where it belongs but for the half pixel by which the grids differ.
TEST_F(LayoutTools, OiiotoolAndExrenvmapAgreeOnTheFaces) {
    SKIP_WITHOUT("oiiotool");
    SKIP_WITHOUT("exrenvmap");
    for (const int n : {64, 512}) {
        const Cubemap cube = test::direction_cubemap(n);
        for (const CubeFace face : kCubeFaces) {
            const std::string gl = std::string(kGlFaceNames[static_cast<size_t>(index_of(face))]);
            const std::string exr = std::string(kFaceNames[static_cast<size_t>(index_of(face))]);
            write(gl + ".exr", gl_face_of(cube, face), ExrLayout::kPlain);
            const auto turned = run_tool("oiiotool " + path(gl + ".exr") +
                                         (axis_of(face) == 1 ? " --flip -o " : " --flop -o ") +
                                         path("turned" + exr + ".exr"));
            ASSERT_EQ(turned.status, 0) << turned.text;
        }
        const auto run =
            run_tool("exrenvmap -ci -l -w 128 '" + path("turned%.exr") + "' " + path("all.exr"));
        ASSERT_EQ(run.status, 0) << run.text;
        const Image all = read("all.exr");
        double largest = 0.0;
        for (int y = 0; y < all.height(); ++y) {
            for (int x = 0; x < all.width(); ++x) {
                largest = std::max(
                    largest, degrees_between(coded(all.at(x, y)),
                                             latlong_direction(x, y, all.width(), all.height())));
            }
        }
        std::printf("N = %d: through exrenvmap within %.3f degrees\n", n, largest);
        EXPECT_LT(largest, 60.0 / n + 0.1);
    }
}

/// The triple that cmgen prints before the name of a coefficient.
Vec3 coefficient(const std::string& shown, const std::string& name) {
    const size_t end = shown.find("// " + name + ",");
    const size_t begin = end == std::string::npos ? end : shown.rfind('(', end);
    if (begin == std::string::npos) throw std::runtime_error("no " + name + " in: " + shown);
    Vec3 value;
    const char* const text = shown.c_str() + begin;
    if (std::sscanf(text, "( %lf, %lf, %lf)", &value.x, &value.y, &value.z) != 3) {
        throw std::runtime_error("no triple for " + name + " in: " + shown);
    }
    return value;
}

// Filament's spherical harmonics of our latlong, mirrored as is its default: as --sh-shader scales
// them, 0.5 + 0.5 d has 1/2 in L00 and 1/3 in L11.r, L1-1.g and L10.b. A latlong turned or mirrored
// has not. (It takes pixels to lie at texel centres, which turns the map by up to half a pixel:
// that is what the others may be off. At N = 16 interpolation shortens a third by 0.002.)
TEST_F(LayoutTools, CmgenFindsTheSphericalHarmonics) {
    SKIP_WITHOUT("cmgen");
    for (const auto& [n, first, others] : {std::tuple{16, 0.003, 0.03}, std::tuple{64, 0.001, 0.01},
                                           std::tuple{512, 0.001, 0.002}}) {
        write("latlong.exr", latlong_of(test::direction_cubemap(n)), ExrLayout::kLatlong);
        const auto run = run_tool("cmgen --sh-shader --sh-window=no --sh=3 " + path("latlong.exr"));
        ASSERT_EQ(run.status, 0) << run.text;
        const Vec3 l11 = coefficient(run.text, "L11");
        const Vec3 l1m1 = coefficient(run.text, "L1-1");
        const Vec3 l10 = coefficient(run.text, "L10");
        EXPECT_NEAR(l11.r, 0.3333, first) << n;
        EXPECT_NEAR(l1m1.g, 0.3333, first) << n;
        EXPECT_NEAR(l10.b, 0.3333, first) << n;
        for (const double other : {l11.g, l11.b, l1m1.r, l1m1.b, l10.r, l10.g}) {
            EXPECT_NEAR(other, 0.0, others) << n << "\n" << run.text;
        }
        EXPECT_NEAR(coefficient(run.text, "L00").r, 0.5, 0.005) << n;
    }
}

}  // namespace
}  // namespace probebake
