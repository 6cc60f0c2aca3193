// Files as answers: entity tags, conditions, single ranges, digests (RFC 9110, RFC 9530).
#pragma once

#include <httplib.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "store/open_file.h"

namespace probebake {

/// Where in a file of this size a range is; no value where the text is none that we answer (then
/// the whole file is sent). An empty range cannot be satisfied.
struct ByteRange {
    uint64_t first = 0;
    uint64_t bytes = 0;
};
std::optional<ByteRange> read_range(std::string_view text, uint64_t size_bytes);

/// If-None-Match (RFC 9110, 13.1.2), weakly compared.
bool none_match_fails(const httplib::Request& request, const std::string& etag);

/// The value of Repr-Digest (RFC 9530) for a SHA-256 in hexadecimal digits.
std::string repr_digest(const std::string& sha256);

/// A file whose content is known by its digest: 200, 206, 304 or 416.
void answer_digested(std::shared_ptr<const OpenFile> file, const std::string& sha256,
                     const char* type, const httplib::Request& request,
                     httplib::Response& response);

/// 200, without tag.
void answer_file(std::shared_ptr<const OpenFile> file, const char* type,
                 httplib::Response& response);

}  // namespace probebake
