// The rows of a job: a file of lines, written once and read in pages.
//
//   0123456789abcdef {"probe": ...}\n     XXH3-64 of the JSON text, then the text
//
// Every line proves itself, so that a page is checked without reading the rest of the file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/json.h"
#include "store/open_file.h"

namespace probebake {

std::string write_row_line(const Json& row);

/// Some of a job's rows, as JSON texts, and where the next ones begin.
struct RowPage {
    std::vector<std::string> rows;
    std::optional<uint64_t> next;
};

/// Rows from byte `offset` on, at most `count`: 0 or what a page before gave. No value where no row
/// begins there. Reads no more than the page. Throws IoError for a damaged row.
std::optional<RowPage> read_rows(const OpenFile& file, uint64_t offset, size_t count);

}  // namespace probebake
