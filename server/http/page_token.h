// Where a page goes on, as clients carry it from one page to the next.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace probebake {

/// Of a job's rows: "u" and a count of published units, or "r" and a byte of the file of rows.
struct RowToken {
    bool final_rows = false;
    uint64_t at = 0;
};
/// No value for what write_row_token does not write.
std::optional<RowToken> read_row_token(std::string_view text);
std::string write_row_token(const RowToken& token);

/// Of a list of bakes: the sequence number of the last one that was shown.
std::optional<int64_t> read_bake_token(std::string_view text);

}  // namespace probebake
