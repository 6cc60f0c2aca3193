// What the service reads of a head: guard_head writes one that leaves no doubt, or refuses; ranges
// stay within their file; tags and tokens of pages are what they were written as.
#include <algorithm>
#include <cstdlib>
#include <string>

#include "http/file_answer.h"
#include "http/guard.h"
#include "http/page_token.h"
#include "http/problem.h"

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

size_t count_of(const std::string& text, const std::string& part) {
    size_t count = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
        ++count;
    }
    return count;
}

void check_head(const std::string& head) {
    using namespace probebake;
    const GuardLimits limits;
    try {
        const GuardedHead guarded = guard_head(head, limits, "r-1");
        const std::string& text = guarded.for_library;
        require(text.ends_with("\r\n\r\n") && count_of(text, "\r\n\r\n") == 1);
        require(count_of(text, "\n") == count_of(text, "\r\n"));
        require(count_of(text, "\r") == count_of(text, "\r\n"));
        require(count_of(text, "\r\nContent-Length: ") == 1);
        require(count_of(text, "\r\nX-Request-Id: ") == 1);
        require(count_of(text, "\r\nTransfer-Encoding") == 0);
        require(count_of(text, "\r\nRange") == 0);
        // In the values of headers the library would decode them.
        require(text.find('%', text.find("\r\n")) == std::string::npos);
        require(guarded.body_bytes <= limits.max_body_bytes);
        require(guarded.target.size() <= limits.max_target_bytes && guarded.target[0] == '/');
    } catch (const ProblemError& error) {
        require(error.problem().status >= 400 && error.problem().status <= 501);
    }
}

void check_range(const std::string& text, uint64_t size_bytes) {
    const auto range = probebake::read_range(text, size_bytes);
    if (!range || range->bytes == 0) return;
    require(range->first < size_bytes && range->bytes <= size_bytes - range->first);
}

void check_tags(const std::string& text) {
    // The guard passes nothing else on; the library cuts values at a NUL.
    if (std::any_of(text.begin(), text.end(), [](char c) { return c >= 0 && c < ' '; })) return;
    httplib::Request request;
    request.headers.emplace("If-None-Match", text);
    const std::string tag = "\"0123\"";
    const bool fails = probebake::none_match_fails(request, tag);
    require(fails == (text == "*" || text.find(tag) != std::string::npos));
}

void check_token(const std::string& text) {
    using namespace probebake;
    if (const auto token = read_row_token(text)) {
        const auto again = read_row_token(write_row_token(*token));
        require(again && again->at == token->at && again->final_rows == token->final_rows);
    }
    if (const auto before = read_bake_token(text)) require(*before >= 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string text(reinterpret_cast<const char*>(data), size);
    // As Connection::read_head hands them over: up to the first blank line.
    const size_t blank = text.find("\r\n\r\n");
    check_head(blank == std::string::npos ? text + "\r\n\r\n" : text.substr(0, blank + 4));
    for (const uint64_t size_bytes : {uint64_t{0}, uint64_t{1}, uint64_t{4096}, ~uint64_t{0}}) {
        check_range(text, size_bytes);
        check_range("bytes=" + text, size_bytes);
    }
    check_tags(text);
    check_token(text);
    return 0;
}
