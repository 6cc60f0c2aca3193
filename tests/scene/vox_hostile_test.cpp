// .vox files that are damaged or lie: always an IoError with the chunk and the offset.
#include <gtest/gtest.h>

#include "io/file.h"
#include "scene/vox/vox_import.h"
#include "scene/vox_seeds.h"

namespace probebake {
namespace {

using test::Bytes;
using test::VoxContent;
using test::VoxWriter;

std::string error_of(const Bytes& bytes, const VoxLimits& limits = {}) {
    try {
        import_vox(bytes, "test.vox", limits);
    } catch (const IoError& error) {
        return error.what();
    }
    return "no error";
}

std::string at(uint64_t offset, const std::string& problem) {
    return "test.vox: offset " + std::to_string(offset) + ": " + problem;
}

std::string bad(const std::string& what, const std::string& text, const std::string& expected) {
    return what + " is \"" + text + "\", expected " + expected;
}

constexpr uint64_t kChunkHeader = 12;

/// A model of one voxel.
VoxWriter one_model() { return VoxWriter().model({1, 1, 1}, {{0, 0, 0, 1}}); }

TEST(HostileVox, EveryTruncation) {
    const Bytes whole = test::every_chunk().file();
    ASSERT_EQ(error_of(whole), "no error");
    for (size_t size = 0; size < whole.size(); ++size) {
        const Bytes prefix(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_EQ(error_of(prefix).find("test.vox: offset "), 0u) << size;
    }
}

TEST(HostileVox, EveryTruncationThatTheHeaderAdmitsTo) {
    // MAIN claims what is left, so that the cut is met inside the chunks: the result is an error
    // or, between two chunks, a smaller world.
    const Bytes whole = test::every_chunk().file();
    int imports = 0;
    for (size_t size = 20; size < whole.size(); ++size) {
        Bytes prefix(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        for (size_t i = 0; i < 4; ++i) prefix[16 + i] = std::byte((size - 20) >> (8 * i));
        const std::string error = error_of(prefix);
        if (error == "no error") {
            ++imports;
        } else {
            EXPECT_EQ(error.find("test.vox: offset "), 0u) << error;
            EXPECT_NE(error.find("chunk "), std::string::npos) << error;
        }
    }
    // After the second model (no graph) and after the last shape, two layers, the palette, the
    // index map and the material.
    EXPECT_EQ(imports, 7);
}

TEST(HostileVox, SeedsOfTheFuzzTargetAreValidAndCommitted) {
    const std::filesystem::path corpus =
        std::filesystem::path(PROBEBAKE_SOURCE_DIR) / "tests/fuzz/corpus/vox";
    for (const auto& [name, bytes] : test::vox_seeds()) {
        EXPECT_EQ(error_of(bytes), "no error") << name;
        EXPECT_EQ(read_file(corpus / name), bytes) << name << ": write it with vox_corpus";
    }
}

TEST(HostileVox, EveryByteChanged) {
    const Bytes whole = test::every_chunk().file();
    for (size_t i = 0; i < whole.size(); ++i) {
        for (const unsigned change : {0x01u, 0x80u, 0xFFu}) {
            Bytes bytes = whole;
            bytes[i] ^= std::byte(change);
            const std::string error = error_of(bytes);
            if (error != "no error") {
                EXPECT_EQ(error.find("test.vox: offset "), 0u) << error;
            }
        }
    }
}

TEST(HostileVox, Header) {
    EXPECT_EQ(error_of({}), at(0, "the magic needs 4 bytes, 0 are left"));
    EXPECT_EQ(error_of(VoxContent().text("PNG ").i32(150).bytes()),
              at(0, "is not a MagicaVoxel file"));
    EXPECT_EQ(error_of(one_model().file(151)), at(4, "has version 151, expected 150 or 200"));
    EXPECT_EQ(error_of(VoxContent().text("VOX ").i32(150).text("SIZE").i32(0).i32(0).bytes()),
              at(8, "chunk SIZE: expected chunk MAIN"));
    EXPECT_EQ(error_of(VoxWriter().file()), at(8, "chunk MAIN: holds no model"));
    EXPECT_EQ(error_of(VoxContent().append(one_model().file()).text("more").bytes()),
              at(one_model().offset(), "chunk MAIN ends here, but 4 bytes follow"));
}

TEST(HostileVox, ChunkSizes) {
    const auto with_header = [](int64_t content, int64_t children) {
        VoxContent bytes;
        bytes.text("VOX ").i32(150).text("MAIN").i32(0).i32(16);
        return bytes.text("n\x01RN").i32(content).i32(children).i32(0).bytes();
    };
    EXPECT_EQ(
        error_of(with_header(5, 0)),
        at(20, "chunk MAIN: chunk n?RN has 5 bytes of content and 0 of children, 4 are left"));
    EXPECT_EQ(error_of(with_header(-1, -1)),
              at(20,
                 "chunk MAIN: chunk n?RN has 4294967295 bytes of content and 4294967295 of "
                 "children, 4 are left"));
    EXPECT_EQ(
        error_of(with_header(2, 3)),
        at(20, "chunk MAIN: chunk n?RN has 2 bytes of content and 3 of children, 4 are left"));
    const uint64_t next = one_model().offset();
    EXPECT_EQ(error_of(one_model().chunk("RGBA", VoxContent().i32(0)).file()),
              at(next + kChunkHeader + 4, "chunk RGBA: the palette needs 4 bytes, 0 are left"));
    EXPECT_EQ(error_of(one_model().chunk("IMAP", VoxContent().i32(0)).file()),
              at(next + kChunkHeader + 4, "chunk IMAP: the index map needs 1 bytes, 0 are left"));
    EXPECT_EQ(error_of(VoxWriter().chunk("SIZE", VoxContent().i32(1).i32(1).i32(1).i32(1)).file()),
              at(20 + kChunkHeader + 12, "chunk SIZE: holds 4 more bytes than its contents need"));
}

TEST(HostileVox, Models) {
    EXPECT_EQ(error_of(VoxWriter().model({1, 257, 1}, {}).file()),
              at(20 + kChunkHeader + 4, "chunk SIZE: the model's size is 257, expected 1 to 256"));
    EXPECT_EQ(error_of(VoxWriter().model({1, 1, 0}, {}).file()),
              at(20 + kChunkHeader + 8, "chunk SIZE: the model's size is 0, expected 1 to 256"));
    EXPECT_EQ(error_of(VoxWriter().size({1, 1, 1}).size({1, 1, 1}).file()),
              at(20, "chunk SIZE: is not followed by a chunk XYZI"));
    EXPECT_EQ(error_of(VoxWriter().size({1, 1, 1}).file()),
              at(20, "chunk SIZE: is not followed by a chunk XYZI"));
    EXPECT_EQ(error_of(one_model().voxels({}).file()),
              at(one_model().offset(), "chunk XYZI: has no SIZE chunk before it"));
    const uint64_t voxels = VoxWriter().size({2, 2, 2}).offset() + kChunkHeader;
    EXPECT_EQ(error_of(VoxWriter().model({2, 2, 2}, {{1, 1, 1, 1}, {0, 2, 0, 1}}).file()),
              at(voxels + 8, "chunk XYZI: voxel 1 lies outside its model's size"));
    const auto counts = [](int64_t count) {
        return VoxWriter().size({2, 2, 2}).chunk("XYZI", VoxContent().i32(count).i32(0)).file();
    };
    EXPECT_EQ(error_of(counts(2)), at(voxels + 4,
                                      "chunk XYZI: says that it has 2 voxels of 4 bytes, "
                                      "4 bytes follow"));
    EXPECT_EQ(error_of(counts(0x4000'0001)),
              at(voxels + 4,
                 "chunk XYZI: says that it has 1073741825 voxels of 4 bytes, 4 bytes follow"));
    EXPECT_EQ(error_of(one_model().chunk("PACK", VoxContent().i32(2)).file()),
              at(one_model().offset() + kChunkHeader,
                 "chunk PACK: says that there are 2 models, the file has 1"));
}

TEST(HostileVox, Nodes) {
    const uint64_t next = one_model().offset();
    EXPECT_EQ(error_of(one_model().shape(0, 1).file()),
              at(next, "chunk nSHP: node 0 names model 1, the file has 1 models"));
    EXPECT_EQ(error_of(one_model().shape(0, -1).file()),
              at(next, "chunk nSHP: node 0 names model 4294967295, the file has 1 models"));
    EXPECT_EQ(error_of(one_model().transform(0, 7).file()),
              at(next, "chunk nTRN: node 0 has child 7, which is no node of the file"));
    EXPECT_EQ(error_of(one_model().group(0, {-9}).file()),
              at(next, "chunk nGRP: node 0 has child -9, which is no node of the file"));
    EXPECT_EQ(error_of(one_model().shape(1, 0).file()),
              at(next, "chunk nSHP: node 1 is the lowest, expected a root 0"));
    EXPECT_EQ(error_of(one_model().shape(0, 0).shape(0, 0).file()),
              at(one_model().shape(0, 0).offset(), "chunk nSHP: node 0 occurs twice"));
    EXPECT_EQ(error_of(one_model().chunk("nSHP", VoxContent().i32(0).dictionary({}).i32(0)).file()),
              at(next + kChunkHeader + 8, "chunk nSHP: has no model, expected at least one"));
    EXPECT_EQ(
        error_of(
            one_model().chunk("nGRP", VoxContent().i32(0).dictionary({}).i32(2).i32(1)).file()),
        at(next + kChunkHeader + 12,
           "chunk nGRP: says that it has 2 children of 4 bytes, 4 bytes follow"));
    VoxContent no_frame;
    no_frame.i32(0).dictionary({}).i32(1).i32(-1).i32(0).i32(0);
    EXPECT_EQ(error_of(one_model().chunk("nTRN", no_frame).file()),
              at(next + kChunkHeader + 20, "chunk nTRN: has no frame, expected at least one"));
    VoxContent many_frames;
    many_frames.i32(0).dictionary({}).i32(1).i32(-1).i32(0).i32(-1);
    EXPECT_EQ(error_of(one_model().chunk("nTRN", many_frames).file()),
              at(next + kChunkHeader + 24,
                 "chunk nTRN: the size of a dictionary needs 4 bytes, 0 are left"));
}

TEST(HostileVox, Dictionaries) {
    const uint64_t begin = one_model().offset() + kChunkHeader;
    EXPECT_EQ(error_of(one_model().chunk("LAYR", VoxContent().i32(0).i32(-1)).file()),
              at(begin + 4, "chunk LAYR: a dictionary has 4294967295 pairs, expected at most 256"));
    EXPECT_EQ(error_of(one_model().chunk("LAYR", VoxContent().i32(0).i32(256)).file()),
              at(begin + 8, "chunk LAYR: the length of a string needs 4 bytes, 0 are left"));
    EXPECT_EQ(error_of(one_model().chunk("LAYR", VoxContent().i32(0).i32(1).i32(-1).i32(0)).file()),
              at(begin + 12, "chunk LAYR: a key needs 4294967295 bytes, 4 are left"));
    EXPECT_EQ(error_of(one_model().layer(-1, {}).file()),
              at(begin, "chunk LAYR: the layer's id is -1, expected 0 or more"));
    EXPECT_EQ(error_of(one_model().layer(0, {{"_hidden", "yes"}}).file()),
              at(begin + 4 + 4 + (4 + 7) + 4, "chunk LAYR: _hidden is \"yes\", expected 0 or 1"));
    EXPECT_EQ(error_of(one_model().material(257, {}).file()),
              at(begin, "chunk MATL: the material's id is 257, expected 0 to 256"));
}

TEST(HostileVox, Amounts) {
    const uint64_t value = one_model().offset() + kChunkHeader + 8 + (4 + 5 + 4 + 5) + (4 + 5 + 4);
    const auto emission = [&](const std::string& key, const std::string& text) {
        return error_of(one_model().material(1, {{"_type", "_emit"}, {key, text}}).file());
    };
    for (const std::string text : {"", "x", "1x", "nan", "inf", "-1", "1001", "1e400", " 1"}) {
        const std::string key = text.empty() ? "_flux" : "_emit";
        const std::string largest = text.empty() ? "10" : "1000";
        EXPECT_EQ(emission(key, text),
                  at(value, bad("chunk MATL: " + key, text, "a number from 0 to " + largest)));
    }
    EXPECT_EQ(emission("_flux", "10.5"),
              at(value, "chunk MATL: _flux is \"10.5\", expected a number from 0 to 10"));
}

TEST(HostileVox, Transforms) {
    const uint64_t value = one_model().offset() + kChunkHeader + 28 + (4 + 2 + 4);
    const auto frame = [&](const std::string& key, const std::string& text) {
        return error_of(one_model().transform(0, 1, {{key, text}}).shape(1, 0).file());
    };
    // Columns 3 or equal columns, beyond a byte, no number: none of these is a permutation.
    for (const std::string text :
         {"3", "0", "5", "12", "128", "132", "-4", "", "4 ", "0x11", "99999999999999999999"}) {
        EXPECT_EQ(frame("_r", text),
                  at(value,
                     bad("chunk nTRN: _r", text, "a rotation packed into a number from 0 to 127")));
    }
    for (const std::string text : {"", "1", "1 2", "1 2 3 4", "1 2 3 ", "1  2 3", "1 2 x", "1,2,3",
                                   "2147483648 0 0", "0 -2147483649 0", "0 0 1e3"}) {
        EXPECT_EQ(frame("_t", text),
                  at(value, bad("chunk nTRN: _t", text, "three integers of 32 bits")));
    }
    EXPECT_EQ(frame("_t", std::string(1000, '9')),
              at(value,
                 bad("chunk nTRN: _t", std::string(32, '9') + "...", "three integers of 32 bits")));
    EXPECT_EQ(frame("_t", "2147483647 -2147483647 -2147483648"), "no error");
    // A translation of −2^31 along y would be 2^31 − 1 along z; one more cell does not fit.
    EXPECT_EQ(frame("_t", "0 -2147483648 0"), "no error");
}

TEST(HostileVox, CoordinatesBeyond32Bits) {
    VoxWriter writer = one_model();
    writer.transform(0, 1, {{"_t", "2147483647 0 0"}}).transform(1, 2, {{"_t", "1 0 0"}});
    const uint64_t shape = writer.offset();
    EXPECT_EQ(error_of(writer.shape(2, 0).file()),
              at(shape, "chunk nSHP: node 2 lies beyond 32-bit coordinates"));
}

TEST(HostileVox, ExtentsBeyondTheTree) {
    const auto far_apart = [](const std::string& translation) {
        VoxWriter writer = one_model();
        writer.transform(0, 1).group(1, {2, 3}).shape(2, 0).transform(3, 4, {{"_t", translation}});
        const uint64_t second_shape = writer.offset();
        return std::pair(writer.shape(4, 0).file(), second_shape);
    };
    EXPECT_EQ(error_of(far_apart("65535 -65535 65535").first), "no error");
    for (const auto& [translation, extent] :
         {std::pair<std::string, std::string>{"0 65536 0", "65537"},
          {"-65536 0 0", "65537"},
          {"0 0 2147483647", "2147483648"},
          {"0 -2147483648 0", "2147483649"}}) {
        const auto [bytes, shape] = far_apart(translation);
        EXPECT_EQ(error_of(bytes), at(shape, "chunk nSHP: node 4 brings the world to " + extent +
                                                 " voxels along an axis, the limit is 65536"));
    }
}

TEST(HostileVox, Cycles) {
    const auto graph = [](int back) {
        return one_model()
            .transform(0, 1)
            .group(1, {2})
            .transform(2, 3)
            .group(3, {4, back})
            .shape(4, 0);
    };
    EXPECT_EQ(error_of(graph(1).file()),
              at(one_model().transform(0, 1).offset(),
                 "chunk nGRP: node 1 is below itself in the scene graph"));
    EXPECT_EQ(error_of(graph(3).file()),
              at(one_model().transform(0, 1).group(1, {2}).transform(2, 3).offset(),
                 "chunk nGRP: node 3 is below itself in the scene graph"));
    EXPECT_EQ(error_of(graph(4).file()), "no error");
}

/// `levels` transforms above one another, then a shape.
VoxWriter chain(int levels) {
    VoxWriter writer = one_model();
    for (int i = 0; i < levels; ++i) writer.transform(i, i + 1);
    return writer.shape(levels, 0);
}

TEST(HostileVox, Depth) {
    EXPECT_EQ(error_of(chain(127).file()), "no error");
    EXPECT_NE(error_of(chain(128).file()).find("chunk nSHP: node 128 is more than 128 nodes deep"),
              std::string::npos);
    EXPECT_NE(
        error_of(chain(100'000).file()).find("chunk nTRN: node 128 is more than 128 nodes deep"),
        std::string::npos);
}

/// Groups that hold the next one twice: 2^levels ways to the last node.
VoxWriter doubling(int levels, const test::Pairs& attributes = {}) {
    VoxWriter writer = one_model();
    for (int i = 0; i < levels; ++i) writer.group(i, {i + 1, i + 1}, attributes);
    return writer;
}

TEST(HostileVox, ExponentiallyManyInstances) {
    EXPECT_NE(error_of(doubling(40).shape(40, 0).file())
                  .find("chunk nSHP: node 40 is one instance more than the limit of 65536"),
              std::string::npos);
    // Nor may ways that place nothing take for ever.
    const std::string visits =
        "is met after 4194304 others, the most that a scene graph may lead to";
    EXPECT_NE(error_of(doubling(40).group(40, {}).file()).find(visits), std::string::npos);
    EXPECT_NE(error_of(doubling(40, {{"_hidden", "1"}}).shape(40, 0).file()).find(visits),
              std::string::npos);
}

TEST(HostileVox, Limits) {
    const Bytes sixteen = doubling(4).shape(4, 0).file();
    VoxLimits limits{.max_voxels = 16, .max_instances = 16, .max_node_visits = 31, .max_depth = 5};
    EXPECT_EQ(error_of(sixteen, limits), "no error");
    const auto expect = [&](const VoxLimits& tighter, const std::string& problem) {
        const std::string error = error_of(sixteen, tighter);
        EXPECT_NE(error.find("chunk nSHP: node 4 " + problem), std::string::npos) << error;
    };
    VoxLimits tight = limits;
    tight.max_voxels = 15;
    expect(tight, "brings the voxels to 16, the limit is 15");
    tight = limits;
    tight.max_instances = 15;
    expect(tight, "is one instance more than the limit of 15");
    tight = limits;
    tight.max_node_visits = 30;
    expect(tight, "is met after 30 others");
    tight = limits;
    tight.max_depth = 4;
    expect(tight, "is more than 4 nodes deep");
    // Of the file without scene graph, the model is to blame.
    EXPECT_EQ(error_of(one_model().file(), {.max_voxels = 0}),
              at(VoxWriter().size({1, 1, 1}).offset(),
                 "chunk XYZI: the model brings the voxels to 1, the limit is 0"));
    // Hard limits stay where a caller allows more.
    EXPECT_NE(error_of(doubling(17).shape(17, 0).file(), {.max_instances = 1 << 20})
                  .find("the limit of 65536"),
              std::string::npos);
}

TEST(HostileVox, ManySmallModelsOfLargeSize) {
    // 20,000 models of 256³ cells and no voxel: nothing may be done per cell.
    VoxWriter writer;
    for (int i = 0; i < 20'000; ++i) writer.model({256, 256, 256}, {{255, 255, 255, 1}});
    EXPECT_EQ(error_of(writer.file()), "no error");
}

}  // namespace
}  // namespace probebake
