#include "jobs/rows.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "io/io_error.h"

namespace probebake {
namespace {

constexpr size_t kSumDigits = 16;

std::string sum_of(std::string_view text) {
    std::array<char, kSumDigits + 1> digits{};
    std::snprintf(digits.data(), digits.size(), "%016llx",
                  static_cast<unsigned long long>(XXH3_64bits(text.data(), text.size())));
    return digits.data();
}

std::string checked(const std::string& line) {
    std::string text = line.substr(std::min(line.size(), kSumDigits + 1));
    if (line.compare(0, kSumDigits, sum_of(text)) != 0) {
        throw IoError("rows", "a row is damaged");
    }
    return text;
}

}  // namespace

std::string write_row_line(const Json& row) {
    const std::string text = dump_json(row);
    return sum_of(text) + " " + text + "\n";
}

std::optional<RowPage> read_rows(const OpenFile& file, uint64_t offset, size_t count) {
    if (offset > file.size_bytes()) return std::nullopt;
    if (offset > 0) {
        char before = 0;
        file.read_at(offset - 1, {&before, 1});
        if (before != '\n') return std::nullopt;
    }
    RowPage page;
    std::string line;
    std::array<char, 16384> buffer{};
    uint64_t at = offset;
    while (page.rows.size() < count) {
        const size_t n = file.read_at(at, buffer);
        if (n == 0) break;
        for (size_t i = 0; i < n && page.rows.size() < count; ++i) {
            ++at;
            if (buffer[i] != '\n') {
                line += buffer[i];
            } else {
                page.rows.push_back(checked(line));
                line.clear();
            }
        }
    }
    if (at < file.size_bytes()) page.next = at;
    return page;
}

}  // namespace probebake
