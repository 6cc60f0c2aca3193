// Lines through media: pieces in order, bounds that hold, look-ups that are the media's own.
#include "track/media_line.h"

#include "support/ray_families.h"
#include "volume/volume_fixture.h"

namespace probebake {
namespace {

GridShape cloud(const Vec3& offset, double scale, uint64_t seed) {
    const double c = std::cos(0.3);
    const double s = std::sin(0.3);
    Affine map;
    map.linear = glm::dmat3(c, s, 0, -s, c, 0, 0, 0, 1) * scale;
    map.offset = offset;
    return {std::make_shared<DensityGrid>(test::noise_grid({0, 0, 0}, {20, 18, 16}, seed)), map,
            nullptr};
}

std::vector<MediumSpec> several() {
    return {
        {.name = "cloud",
         .absorption_per_m = Rgb(0.1f, 0.2f, 0.3f),
         .scattering_per_m = Rgb(1, 2, 3),
         .shape = cloud({-4, -4, -4}, 0.5, 1)},
        {.name = "other", .scattering_per_m = Rgb(0.5f), .shape = cloud({-2, -6, -3}, 0.4, 2)},
        {.name = "box",
         .scattering_per_m = Rgb(0.2f, 0.1f, 0.05f),
         .shape = HomogeneousShape{Box{{-2, -2, -9}, {3, 1, 2}}}},
        {.name = "fog",
         .absorption_per_m = Rgb(0.1f),
         .shape = FogShape{.base_m = -1.0, .scale_height_m = 2.0}},
    };
}

void expect_sound(const Media& media, uint64_t seed) {
    for (const test::RayFamily& family : test::ray_families()) {
        if (!family.well_defined || family.name == "origins 1e6 away") continue;
        RandomStream random(random_key({seed}));
        for (int i = 0; i < 100; ++i) {
            Ray ray = family.make(random, 8.0);
            ray.origin -= 4.012345;
            ray.direction = glm::normalize(ray.direction);
            const TRange range{random.uniform(), 10.0 + 10.0 * random.uniform()};
            MediaLine<3> line(media, ray, range);
            MediaLine<1> gray(media, ray, range);
            Segment<3> piece;
            Segment<1> gray_piece;
            double t = 0.0;
            Spectrum<3> tau_least;
            Spectrum<3> tau_most;
            while (line.next(piece)) {
                ASSERT_TRUE(gray.next(gray_piece));
                ASSERT_EQ(gray_piece.t1, piece.t1);
                ASSERT_GE(piece.t0, t) << family.name;
                ASSERT_GE(piece.t1, piece.t0) << family.name;
                ASSERT_LE(piece.t1, range.end) << family.name;
                t = piece.t1;
                tau_least += piece.least.extinction() * piece.length();
                tau_most += piece.most.extinction() * piece.length();
                for (const double f : {0.001, 0.5, 0.999}) {
                    const double at = piece.t0 + f * piece.length();
                    const Coefficients<3> got = line.at(at);
                    const Coefficients<3> exact = media.at(ray.origin + ray.direction * at);
                    for (int c = 0; c < 3; ++c) {
                        ASSERT_NEAR(got.scattering[c], exact.scattering[c], 1e-6) << family.name;
                        ASSERT_NEAR(got.absorption[c], exact.absorption[c], 1e-6) << family.name;
                        ASSERT_GE(got.extinction()[c], piece.least.extinction()[c] * (1 - 1e-12));
                        ASSERT_LE(got.extinction()[c], piece.most.extinction()[c] * (1 + 1e-12));
                    }
                    ASSERT_NEAR(gray.at(at).scattering[0], exact.extinction()[1], 1e-6);
                }
            }
            ASSERT_EQ(line.unbounded(), 0u) << family.name;
            const Spectrum<3> tau = media.optical_depth(ray, range);
            for (int c = 0; c < 3; ++c) {
                ASSERT_LE(tau_least[c], tau[c] * (1 + 1e-9) + 1e-12) << family.name;
                ASSERT_GE(tau_most[c], tau[c] * (1 - 1e-9) - 1e-12) << family.name;
            }
        }
    }
}

TEST(MediaLine, PiecesBoundEachMediumAlone) {
    for (const MediumSpec& spec : several()) {
        SCOPED_TRACE(spec.name);
        expect_sound(Media({spec}, {.max_depth = 5, .threshold = 0.05}), 1);
    }
}

TEST(MediaLine, PiecesBoundTheSumOfOverlappingMedia) {
    expect_sound(Media(several(), {.max_depth = 5, .threshold = 0.05}), 2);
}

TEST(MediaLine, FogToTheHorizonIsOnePieceAndUpwardsEnds) {
    const Media media({several()[3]});
    Segment<1> piece;
    MediaLine<1> along(media, {{0, 5, 0}, {1, 0, 0}}, {});
    ASSERT_TRUE(along.next(piece));
    EXPECT_GT(piece.t1, 1e100);
    EXPECT_NEAR(piece.most.extinction()[0], 0.1 * std::exp(-3.0), 1e-9);
    MediaLine<1> up(media, {{0, -5, 0}, {0, 1, 0}}, {});
    int pieces = 0;
    while (up.next(piece)) ++pieces;
    EXPECT_EQ(piece.t1, 4.0 + 2.0 * kFogScaleHeights);
    EXPECT_LT(pieces, 62);
}

TEST(MediaLine, EmissionIsThatOfItsOwnGrid) {
    GridShape shape = cloud({-4, -4, -4}, 0.5, 1);
    shape.emission = std::make_shared<DensityGrid>(test::noise_grid({0, 0, 0}, {20, 18, 16}, 7));
    const Affine to_index = shape.index_to_world.inverse();
    const Media media({{.name = "fire",
                        .absorption_per_m = Rgb(0.5f, 0.25f, 0.0f),
                        .scattering_per_m = Rgb(1.0f),
                        .emission = Rgb(2.0f, 8.0f, 0.0f),
                        .shape = shape}});
    const Ray ray{{-10, 0.3, 0.2}, {1, 0, 0}};
    MediaLine<3> line(media, ray, {});
    Segment<3> piece;
    double brightest = 0.0;
    while (line.next(piece)) {
        const double t = 0.5 * (piece.t0 + piece.t1);
        const double density = line.at(t).scattering[0];
        const Vec3 index = to_index.point(ray.origin + ray.direction * t);
        const double expected = density * shape.emission->sample(index);
        const Spectrum<3> emitted = line.emitted_per_m(t);
        EXPECT_NEAR(emitted[0], 1.0 * expected, 1e-9);
        EXPECT_NEAR(emitted[1], 2.0 * expected, 1e-9);
        EXPECT_EQ(emitted[2], 0.0);
        brightest = std::max(brightest, expected);
    }
    EXPECT_GT(brightest, 0.0);
}

TEST(MediaLine, ACollisionBelongsToItsComponent) {
    const Media media({several()[2], several()[3]});
    MediaLine<3> line(media, {{0, 0.5, -5}, {0, 0, 1}}, {});
    Segment<3> piece;
    ASSERT_TRUE(line.next(piece));
    line.at(0.5);
    const Densities all = line.collided({Event::kScatter, 0.5, false}, false);
    EXPECT_EQ(all[0], 1.0);
    EXPECT_NEAR(all[1], std::exp(-0.75), 1e-9);
    EXPECT_NEAR(line.collided({Event::kScatter, 0.5, true}, true)[1], all[1], 1e-9);
    EXPECT_NEAR(line.collided({Event::kScatter, 0.5, false}, true)[1], 0.0, 1e-9);
}

}  // namespace
}  // namespace probebake
