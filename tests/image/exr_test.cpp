#include "image/exr.h"

#include <ImfThreading.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "image/cubemaps.h"

namespace probebake {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

ProbeAttributes full_attributes() {
    ProbeAttributes attributes;
    attributes.owner = "The owner's name";
    attributes.comments = "probebake; 1 voxel = 0.1 m, ünïcode";
    attributes.id = "grid-1-2-3";
    attributes.state = "noon";
    attributes.position_m = {0.1, -1e7 - 1.0 / 3.0, 5e-324};
    attributes.near_m = 0.05;
    attributes.far_m = 1e4;
    attributes.unit = "1";
    attributes.scene_sha256 = std::string(64, 'a');
    attributes.seed = ~uint64_t{0};
    attributes.valid = false;
    attributes.texts["probe:err:evidence"] = "59 pixels";
    attributes.texts["probe:empty"] = "";
    attributes.numbers["probe:err:rmse"] = 0.1;
    attributes.numbers["probe:err:a_name_longer_than_thirty_one_characters"] = -kInfinity;
    return attributes;
}

template <class Function>
std::string message_of(const Function& function) {
    try {
        function();
    } catch (const std::domain_error& error) {
        return error.what();
    }
    return "no error";
}

TEST(Exr, HalfFilesReadBackAsRounded) {
    for (const int n : {1, 2, 3, 4, 16, 64, 512}) {
        const Cubemap cubemap = test::random_cubemap(n, 11, n == 4 ? 65000.0 : 3.0);
        const EncodedCubemap encoded = encode_cubemap(cubemap, full_attributes());
        const DecodedCubemap decoded = decode_cubemap(encoded.bytes, "cube.exr");
        EXPECT_FALSE(encoded.is_float);
        EXPECT_FALSE(decoded.is_float);
        EXPECT_EQ(decoded.attributes, full_attributes());
        EXPECT_TRUE(decoded.cubemap == rounded_to_file(cubemap)) << n;
        EXPECT_FALSE(decoded.cubemap == cubemap) << n;
        const auto read = decoded.cubemap.image().pixels();
        for (size_t i = 0; i < read.size(); ++i) {
            const Rgb exact = cubemap.image().pixels()[i];
            for (int c = 0; c < 3; ++c) {
                // 11 significant bits; 2^-24 apart below 2^-14.
                ASSERT_LE(std::abs(read[i][c] - exact[c]), std::max(exact[c] * 0x1p-11f, 0x1p-25f))
                    << n << " pixel " << i;
            }
        }
    }
}

TEST(Exr, FloatFilesKeepABrightEmitter) {
    for (const int n : {1, 2, 3, 4, 16, 64, 512}) {
        Cubemap cubemap = test::random_cubemap(n, 12);
        cubemap.at({CubeFace::kNegY, n / 2, n / 2}).g = 1e6f;
        cubemap.share_edges();
        const bool kept = rounded_to_file(cubemap) == cubemap;
        const EncodedCubemap encoded = encode_cubemap(cubemap, {});
        const DecodedCubemap decoded = decode_cubemap(encoded.bytes, "cube.exr");
        // With N = 2 every pixel is a corner, and −Y owns none of them.
        EXPECT_EQ(encoded.is_float, n != 2);
        EXPECT_EQ(decoded.is_float, encoded.is_float);
        EXPECT_EQ(kept, encoded.is_float);
        EXPECT_TRUE(decoded.cubemap == rounded_to_file(cubemap)) << n;
    }
}

TEST(Exr, IsFloatAboveTheLargestHalfOnly) {
    const auto with_largest = [](float value) {
        return test::make_cubemap(4, [&](const CubePixel&) { return Rgb(0.1f, value, 0.0f); });
    };
    const Cubemap largest = with_largest(65504.0f);
    EXPECT_FALSE(encode_cubemap(largest, {}).is_float);
    EXPECT_EQ(rounded_to_file(largest).at({}).g, 65504.0f);
    EXPECT_NE(rounded_to_file(largest).at({}).r, 0.1f);
    const Cubemap above = with_largest(std::nextafter(65504.0f, 1e9f));
    EXPECT_TRUE(encode_cubemap(above, {}).is_float);
    EXPECT_TRUE(rounded_to_file(above) == above);
}

TEST(Exr, RoundsToNearestEven) {
    const std::vector<std::pair<float, float>> known = {
        {2049.0f, 2048.0f},   {2051.0f, 2052.0f}, {2049.01f, 2050.0f},    {1.0f, 1.0f},
        {0x1p-24f, 0x1p-24f}, {0x1p-25f, 0.0f},   {0x1.8p-25f, 0x1p-24f}, {1e-30f, 0.0f}};
    for (const auto& [value, rounded] : known) {
        const Cubemap cubemap =
            test::make_cubemap(2, [v = value](const CubePixel&) { return Rgb(v); });
        EXPECT_EQ(rounded_to_file(cubemap).at({}), Rgb(rounded)) << value;
        EXPECT_EQ(decode_cubemap(encode_cubemap(cubemap, {}).bytes, "f").cubemap.at({}),
                  Rgb(rounded))
            << value;
    }
}

TEST(Exr, AttributesThatAreNotSetAreTheDefaults) {
    const ProbeAttributes defaults;
    const EncodedCubemap encoded = encode_cubemap(test::random_cubemap(4, 1), defaults);
    EXPECT_EQ(decode_cubemap(encoded.bytes, "cube.exr").attributes, defaults);
}

TEST(Exr, RefusesNamesThatCollideOrCannotBeStored) {
    const Cubemap cubemap(4);
    for (const std::string& name :
         {std::string("probe:seed"), std::string("owner"), std::string("err:rmse"), std::string(),
          "probe:" + std::string(250, 'x'), std::string("probe:a\0b", 9)}) {
        ProbeAttributes attributes;
        attributes.texts[name] = "text";
        EXPECT_THROW(encode_cubemap(cubemap, attributes), std::invalid_argument) << name;
        attributes.texts.clear();
        attributes.numbers[name] = 1.0;
        EXPECT_THROW(encode_cubemap(cubemap, attributes), std::invalid_argument) << name;
    }
    ProbeAttributes twice;
    twice.texts["probe:a"] = "";
    twice.numbers["probe:a"] = 0.0;
    EXPECT_THROW(encode_cubemap(cubemap, twice), std::invalid_argument);
    ProbeAttributes longest;
    longest.texts["probe:" + std::string(249, 'x')] = "text";
    const EncodedCubemap encoded = encode_cubemap(cubemap, longest);
    EXPECT_EQ(decode_cubemap(encoded.bytes, "cube.exr").attributes, longest);
}

TEST(Exr, RefusesValuesThatAreNoRadianceAndSaysWhere) {
    for (const float bad : {std::nanf(""), kInfinity, -kInfinity, -1.0f, -1e-30f}) {
        Cubemap cubemap = test::random_cubemap(16, 4);
        cubemap.at({CubeFace::kPosZ, 3, 7}).b = bad;
        for (const std::string& message : {message_of([&] { encode_cubemap(cubemap, {}); }),
                                           message_of([&] { rounded_to_file(cubemap); })}) {
            EXPECT_NE(message.find("face +Z, pixel (3, 7), channel B"), std::string::npos)
                << message;
        }
    }
    EXPECT_NO_THROW(
        encode_cubemap(test::make_cubemap(2, [](const CubePixel&) { return Rgb(-0.0f); }), {}));
}

TEST(Exr, RefusesEdgesThatAreNotShared) {
    Cubemap cubemap = test::random_cubemap(16, 4);
    cubemap.at({CubeFace::kNegZ, 15, 7}).r += 0.25f;
    const std::string message = message_of([&] { encode_cubemap(cubemap, {}); });
    EXPECT_NE(message.find("face -Z, pixel (15, 7) differs from face +X, pixel (0, 7)"),
              std::string::npos)
        << message;
}

TEST(Exr, RefusesSizesThatCannotBeWritten) {
    EXPECT_THROW(encode_cubemap(Cubemap(), {}), std::invalid_argument);
    EXPECT_THROW(encode_aux({.face_size = 4, .pixels = std::vector<AuxPixel>(95)}, {}),
                 std::invalid_argument);
    EXPECT_THROW(encode_aux({.face_size = kMaxFaceSize_px + 1, .pixels = {}}, {}),
                 std::invalid_argument);
}

TEST(Exr, BytesDoNotDependOnThreads) {
    const Cubemap cubemap = test::random_cubemap(64, 21);
    const int threads_before = Imf::globalThreadCount();
    const std::vector<std::byte> expected = encode_cubemap(cubemap, full_attributes()).bytes;
    for (const int threads : {1, 2, 7}) {
        Imf::setGlobalThreadCount(threads);
        EXPECT_EQ(encode_cubemap(cubemap, full_attributes()).bytes, expected) << threads;
        EXPECT_EQ(decode_cubemap(expected, "f").cubemap, rounded_to_file(cubemap)) << threads;
    }
    Imf::setGlobalThreadCount(threads_before);
    std::array<std::vector<std::byte>, 7> encoded;
    {
        std::array<std::jthread, 7> workers;
        for (size_t i = 0; i < workers.size(); ++i) {
            workers[i] = std::jthread(
                [&, i] { encoded[i] = encode_cubemap(cubemap, full_attributes()).bytes; });
        }
    }
    for (const auto& bytes : encoded) EXPECT_EQ(bytes, expected);
}

CubeAux random_aux(int n) {
    RandomStream random(6);
    CubeAux aux{n, std::vector<AuxPixel>(6 * static_cast<size_t>(n) * static_cast<size_t>(n))};
    for (AuxPixel& p : aux.pixels) {
        const auto value = [&] { return static_cast<float>(1e5 * random.uniform()); };
        p.z_m = value();
        p.z2_m2 = p.z_m * p.z_m;
        p.standard_error = {value(), 1e-6f * value(), 0.0f};
        p.samples = static_cast<uint32_t>(random.next());
    }
    return aux;
}

TEST(ExrAux, ReadsBackWhatWasWritten) {
    for (const int n : {1, 2, 4, 16, 64}) {
        CubeAux aux = random_aux(n);
        aux.pixels[0].z_m = kInfinity;
        aux.pixels[1].z2_m2 = kInfinity;
        aux.pixels[2].standard_error = Rgb(kInfinity);
        const std::vector<std::byte> bytes = encode_aux(aux, full_attributes());
        const DecodedAux decoded = decode_aux(bytes, "aux.exr");
        EXPECT_TRUE(decoded.aux == aux) << n;
        EXPECT_EQ(decoded.attributes, full_attributes());
        EXPECT_EQ(encode_aux(aux, full_attributes()), bytes);
        EXPECT_THROW(decode_cubemap(bytes, "aux.exr"), IoError);
    }
}

TEST(ExrAux, RefusesNaNAndNegativeValues) {
    for (const float bad : {std::nanf(""), -1.0f}) {
        CubeAux aux = random_aux(4);
        aux.pixels[17].standard_error.g = bad;
        const std::string message = message_of([&] { encode_aux(aux, {}); });
        EXPECT_NE(message.find("face -X, pixel (1, 0), channel stderr.G"), std::string::npos)
            << message;
        aux = random_aux(4);
        aux.pixels[0].z2_m2 = bad;
        EXPECT_NE(message_of([&] { encode_aux(aux, {}); }).find("channel Z2"), std::string::npos);
    }
}

}  // namespace
}  // namespace probebake
