#include "http/file_answer.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <vector>

#include "http/guard.h"
#include "http/problem.h"
#include "http/query.h"
#include "io/io_error.h"

namespace probebake {
namespace {

constexpr size_t kChunkBytes = size_t{64} << 10;

/// Streams a part of an open file. What the library asks for is bounded by that part.
void stream(std::shared_ptr<const OpenFile> file, const ByteRange& part, const char* type,
            httplib::Response& response) {
    response.set_content_provider(
        part.bytes, type,
        [file = std::move(file), part, buffer = std::make_shared<std::vector<char>>(kChunkBytes)](
            size_t offset, size_t length, httplib::DataSink& sink) {
            try {
                const uint64_t left = part.bytes - std::min<uint64_t>(part.bytes, offset);
                const size_t wanted = std::min<uint64_t>({left, length, kChunkBytes});
                const size_t n =
                    file->read_at(part.first + offset, std::span(*buffer).first(wanted));
                return n > 0 && sink.write(buffer->data(), n);
            } catch (const IoError&) {
                return false;  // the answer has begun: all that is left is to break it off
            }
        });
}

std::string base64_of_hex(const std::string& hex) {
    std::array<unsigned char, 32> bytes{};
    for (size_t i = 0; i < bytes.size() && 2 * i + 1 < hex.size(); ++i) {
        bytes[i] = static_cast<unsigned char>(std::stoi(hex.substr(2 * i, 2), nullptr, 16));
    }
    std::array<unsigned char, 48> text{};
    const int n = ::EVP_EncodeBlock(text.data(), bytes.data(), static_cast<int>(bytes.size()));
    return {reinterpret_cast<const char*>(text.data()), static_cast<size_t>(n)};
}

}  // namespace

std::string repr_digest(const std::string& sha256) {
    return "sha-256=:" + base64_of_hex(sha256) + ":";
}

std::optional<ByteRange> read_range(std::string_view text, uint64_t size_bytes) {
    constexpr std::string_view kUnit = "bytes=";
    if (text.substr(0, kUnit.size()) != kUnit) return std::nullopt;
    text.remove_prefix(kUnit.size());
    const size_t dash = text.find('-');
    if (dash == std::string_view::npos) return std::nullopt;
    const std::string_view begin = text.substr(0, dash);
    const std::string_view end = text.substr(dash + 1);
    const std::optional<uint64_t> first = read_digits(begin);
    const std::optional<uint64_t> last = read_digits(end);
    if ((!begin.empty() && !first) || (!end.empty() && !last) || (begin.empty() && end.empty())) {
        return std::nullopt;
    }
    if (begin.empty()) {  // the last so many
        const uint64_t bytes = std::min(*last, size_bytes);
        return ByteRange{size_bytes - bytes, bytes};
    }
    if (last && *last < *first) return std::nullopt;
    if (*first >= size_bytes) return ByteRange{*first, 0};
    const uint64_t stop = last ? std::min(*last, size_bytes - 1) : size_bytes - 1;
    return ByteRange{*first, stop - *first + 1};
}

bool none_match_fails(const httplib::Request& request, const std::string& etag) {
    const std::string opaque = etag.substr(etag.find('"'));  // without the W/ of a weak one
    for (size_t i = 0; i < request.get_header_value_count("If-None-Match"); ++i) {
        const std::string tags = request.get_header_value("If-None-Match", i);
        // A tag of ours holds no comma and no quotation mark inside.
        if (tags == "*" || tags.find(opaque) != std::string::npos) return true;
    }
    return false;
}

void answer_file(std::shared_ptr<const OpenFile> file, const char* type,
                 httplib::Response& response) {
    const uint64_t bytes = file->size_bytes();
    stream(std::move(file), {0, bytes}, type, response);
}

void answer_digested(std::shared_ptr<const OpenFile> file, const std::string& sha256,
                     const char* type, const httplib::Request& request,
                     httplib::Response& response) {
    const std::string etag = "\"" + sha256 + "\"";
    response.set_header("ETag", etag);
    response.headers.erase("Cache-Control");
    response.set_header("Cache-Control", "private, no-cache");  // check with the tag, then use
    response.headers.erase("Accept-Ranges");
    response.set_header("Accept-Ranges", "bytes");
    if (none_match_fails(request, etag)) {
        response.status = 304;
        return;
    }
    const uint64_t size_bytes = file->size_bytes();
    // Ranges are for GET only (RFC 9110, 14.2).
    const bool may_be_part =
        request.method == "GET" &&
        (!request.has_header("If-Range") || request.get_header_value("If-Range") == etag);
    const std::optional<ByteRange> range =
        may_be_part ? read_range(request.get_header_value(kRangeHeader), size_bytes) : std::nullopt;
    const auto tell_digest = [&] { response.set_header("Repr-Digest", repr_digest(sha256)); };
    if (!range) {
        tell_digest();
        answer_file(std::move(file), type, response);
        return;
    }
    if (range->bytes == 0) {
        response.set_header("Content-Range", "bytes */" + std::to_string(size_bytes));
        throw ProblemError({.status = 416,
                            .code = "range-not-satisfiable",
                            .detail = "the file has " + std::to_string(size_bytes) + " bytes"});
    }
    tell_digest();
    response.status = 206;
    response.set_header("Content-Range", "bytes " + std::to_string(range->first) + "-" +
                                             std::to_string(range->first + range->bytes - 1) + "/" +
                                             std::to_string(size_bytes));
    stream(std::move(file), *range, type, response);
}

}  // namespace probebake
