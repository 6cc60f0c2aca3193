#include "http/page_token.h"

#include <limits>

#include "http/query.h"

namespace probebake {

std::optional<RowToken> read_row_token(std::string_view text) {
    if (text.empty() || (text[0] != 'u' && text[0] != 'r')) return std::nullopt;
    const std::optional<uint64_t> at = read_digits(text.substr(1));
    if (!at) return std::nullopt;
    return RowToken{text[0] == 'r', *at};
}

std::string write_row_token(const RowToken& token) {
    return (token.final_rows ? "r" : "u") + std::to_string(token.at);
}

std::optional<int64_t> read_bake_token(std::string_view text) {
    const std::optional<uint64_t> sequence = read_digits(text);
    constexpr auto kLargest = static_cast<uint64_t>(std::numeric_limits<int64_t>::max());
    if (!sequence || *sequence > kLargest) return std::nullopt;
    return static_cast<int64_t>(*sequence);
}

}  // namespace probebake
