#include "jobs/rows.h"

#include <gtest/gtest.h>

#include "io/io_error.h"
#include "support/temp_folder.h"

namespace probebake {
namespace {

std::string many_rows() {
    std::string text;
    // Rows longer than what is read at once, too.
    for (int i = 0; i < 25; ++i) {
        text +=
            write_row_line({{"i", i}, {"text", std::string(static_cast<size_t>(i) * 2000, 'x')}});
    }
    return text;
}

TEST(Rows, ComeInPages) {
    const test::TempFolder folder;
    test::write_text(folder.path() / "rows", many_rows());
    const auto file = OpenFile::open(folder.path() / "rows");
    int next_row = 0;
    std::vector<size_t> pages;
    for (std::optional<uint64_t> at = 0; at;) {
        const auto page = read_rows(*file, *at, 10);
        ASSERT_TRUE(page);
        for (const std::string& row : page->rows) EXPECT_EQ(parse_json(row)["i"], next_row++);
        pages.push_back(page->rows.size());
        at = page->next;
    }
    EXPECT_EQ(pages, (std::vector<size_t>{10, 10, 5}));
    EXPECT_FALSE(read_rows(*file, 1, 10)) << "no row begins there";
    EXPECT_FALSE(read_rows(*file, 1'000'000, 10));
    EXPECT_FALSE(read_rows(*file, ~uint64_t{0}, 10));
}

TEST(Rows, AFlippedBitIsFound) {
    const test::TempFolder folder;
    const std::string good = write_row_line({{"i", 1}, {"text", "abc"}});
    for (size_t bit = 0; bit < 8 * (good.size() - 1); ++bit) {
        std::string bad = good;
        bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << bit % 8));
        test::write_text(folder.path() / "rows", bad);
        const auto file = OpenFile::open(folder.path() / "rows");
        // The space between checksum and text carries nothing.
        if (bit / 8 == 16) continue;
        EXPECT_THROW(read_rows(*file, 0, 10), IoError) << bit;
    }
}

}  // namespace
}  // namespace probebake
