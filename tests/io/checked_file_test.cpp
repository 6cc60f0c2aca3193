#include "io/checked_file.h"

#include <gtest/gtest.h>

#include <numeric>
#include <string>

#include "io/file.h"

namespace probebake {
namespace {

class CheckedFileTest : public testing::Test {
  protected:
    void SetUp() override {
        const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
        path_ = std::filesystem::path(testing::TempDir()) / ("probebake-" + name);
        std::iota(numbers_.begin(), numbers_.end(), 1u);
        const std::span<const std::byte> sections[] = {
            std::as_bytes(std::span(numbers_)), std::as_bytes(std::span(text_)), {}};
        write_checked_file(path_, "test", 3, sections);
    }
    void TearDown() override { std::filesystem::remove(path_); }

    std::string message_of(std::string_view kind = "test", uint64_t version = 3) const {
        try {
            CheckedFile(path_, kind, version);
        } catch (const IoError& error) {
            return error.what();
        }
        return "no error";
    }

    std::filesystem::path path_;
    std::vector<uint32_t> numbers_ = std::vector<uint32_t>(1000);
    std::string text_ = "probes";
};

TEST_F(CheckedFileTest, ReadsBackWhatWasWritten) {
    const CheckedFile file(path_, "test", 3);
    ASSERT_EQ(file.section_count(), 3u);
    EXPECT_EQ(file.array<uint32_t>(0), numbers_);
    EXPECT_EQ(file.array<char>(1), std::vector<char>(text_.begin(), text_.end()));
    EXPECT_TRUE(file.array<uint64_t>(2).empty());
    EXPECT_THROW(file.array<char>(3), IoError);
    EXPECT_THROW(file.array<uint32_t>(1), IoError);
}

TEST_F(CheckedFileTest, EveryFlippedByteIsFound) {
    const std::vector<std::byte> good = read_file(path_);
    for (size_t i = 0; i < good.size(); i += 7) {
        std::vector<std::byte> bad = good;
        bad[i] ^= std::byte{0x10};
        write_file_atomically(path_, bad);
        EXPECT_THROW(CheckedFile(path_, "test", 3), IoError) << "byte " << i;
    }
}

TEST_F(CheckedFileTest, EveryTruncationIsFound) {
    const std::vector<std::byte> good = read_file(path_);
    for (size_t size = 0; size < good.size(); size += 13) {
        write_file_atomically(path_, std::span(good).first(size));
        EXPECT_THROW(CheckedFile(path_, "test", 3), IoError) << size << " bytes";
    }
}

TEST_F(CheckedFileTest, SaysWhatIsWrong) {
    EXPECT_NE(message_of("other").find("kind \"other\""), std::string::npos) << message_of("other");
    EXPECT_NE(message_of("test", 4).find("version 3, expected 4"), std::string::npos);
    std::vector<std::byte> bytes = read_file(path_);
    bytes.back() ^= std::byte{1};
    write_file_atomically(path_, bytes);
    EXPECT_NE(message_of().find("offset 32: is damaged"), std::string::npos) << message_of();
    std::filesystem::remove(path_);
    EXPECT_NE(message_of().find("cannot be opened"), std::string::npos) << message_of();
}

}  // namespace
}  // namespace probebake
