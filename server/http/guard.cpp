#include "http/guard.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "http/problem.h"

namespace probebake {
namespace {

constexpr size_t kMaxAddressBytes = 45;  // of IPv6 in its longest form

[[noreturn]] void refuse(int status, std::string code, std::string detail) {
    throw ProblemError({.status = status, .code = std::move(code), .detail = std::move(detail)});
}

[[noreturn]] void refuse_syntax(std::string detail) {
    refuse(400, "malformed-http", std::move(detail));
}

bool is_token(std::string_view text) {
    constexpr std::string_view kSigns = "!#$%&'*+-.^_`|~";
    return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               kSigns.find(c) != std::string_view::npos;
    });
}

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return out;
}

std::string_view trimmed(std::string_view text) {
    const auto blank = [](char c) { return c == ' ' || c == '\t'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

/// Cuts the next line off `rest`. A line ends in CR LF and holds no other CR or LF.
std::string_view take_line(std::string_view& rest) {
    const size_t end = rest.find_first_of("\r\n");
    if (end == std::string_view::npos || rest.substr(end, 2) != "\r\n") {
        refuse_syntax("a line of the head does not end in CR LF");
    }
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end + 2);
    return line;
}

/// Headers by lower-case name, every value.
using HeaderMap = std::map<std::string, std::vector<std::string>>;

HeaderMap read_headers(std::string_view rest, const GuardLimits& limits) {
    HeaderMap headers;
    size_t count = 0;
    for (;;) {
        const std::string_view line = take_line(rest);
        if (line.empty()) return headers;
        if (++count > limits.max_headers) {
            refuse(431, "head-too-large",
                   "more than " + std::to_string(limits.max_headers) + " headers");
        }
        const size_t colon = line.find(':');
        if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) {
            refuse_syntax("a header is not of the form \"Name: value\"");
        }
        const std::string_view value = trimmed(line.substr(colon + 1));
        const bool plain = std::all_of(value.begin(), value.end(), [](char c) {
            return c == '\t' || static_cast<unsigned char>(c) >= ' ';
        });
        if (!plain) refuse_syntax("a header holds a control character");
        headers[lower(line.substr(0, colon))].emplace_back(value);
    }
}

/// The value of a header that may be there once.
std::optional<std::string> single(const HeaderMap& headers, const std::string& name) {
    const auto at = headers.find(name);
    if (at == headers.end()) return std::nullopt;
    if (at->second.size() > 1) refuse_syntax("the header \"" + name + "\" is repeated");
    return at->second.front();
}

void check_host(const HeaderMap& headers, const GuardLimits& limits) {
    const std::optional<std::string> host = single(headers, "host");
    if (!host) refuse_syntax("the header \"host\" is required");
    std::string name = lower(*host);
    const size_t colon = name.rfind(':');
    if (colon != std::string::npos && name.back() != ']') {
        const bool digits = std::all_of(name.begin() + static_cast<std::ptrdiff_t>(colon) + 1,
                                        name.end(), [](char c) { return c >= '0' && c <= '9'; });
        if (!digits) refuse_syntax("the header \"host\" is not a name with a port");
        name.resize(colon);
    }
    const bool known = std::any_of(limits.hosts.begin(), limits.hosts.end(),
                                   [&](const std::string& ours) { return lower(ours) == name; });
    if (!known) {
        refuse(421, "unknown-host", "this service does not answer to that host name");
    }
}

/// The length of the body, from headers that leave no doubt about it.
uint64_t body_length(const std::string& method, const HeaderMap& headers, uint64_t most_bytes) {
    if (headers.contains("transfer-encoding")) {
        refuse(411, "length-required",
               "expected a body with Content-Length, not with Transfer-Encoding");
    }
    if (headers.contains("content-encoding")) {
        refuse(415, "unsupported-encoding", "expected a body that is not compressed");
    }
    const std::optional<std::string> text = single(headers, "content-length");
    if (!text) return 0;
    const bool digits = !text->empty() && std::all_of(text->begin(), text->end(),
                                                      [](char c) { return c >= '0' && c <= '9'; });
    if (!digits) refuse_syntax("Content-Length is not a number");
    // More than 18 digits do not fit into 64 bits; either way it is too much.
    const uint64_t bytes = text->size() > 18 ? most_bytes + 1 : std::stoull(*text);
    if (bytes > 0 && (method == "GET" || method == "HEAD")) {
        refuse_syntax("a " + method + " request has no body");
    }
    if (bytes > most_bytes) {
        refuse(413, "body-too-large",
               "expected a body of at most " + std::to_string(most_bytes) + " bytes");
    }
    return bytes;
}

void check_content_type(const std::string& type, const std::string& expected) {
    if (lower(trimmed(std::string_view(type).substr(0, type.find(';')))) != expected) {
        refuse(415, "unsupported-media-type", "expected a body of type " + expected);
    }
}

void read_request_line(std::string_view line, const GuardLimits& limits, GuardedHead& out) {
    const size_t first = line.find(' ');
    const size_t last = line.rfind(' ');
    if (first == std::string_view::npos || first == last) {
        refuse_syntax("the request line is not of the form \"METHOD /path HTTP/1.1\"");
    }
    out.method = line.substr(0, first);
    out.target = line.substr(first + 1, last - first - 1);
    out.version = line.substr(last + 1);
    if (!is_token(out.method)) refuse_syntax("the method is not a word");
    if (out.version != "HTTP/1.1" && out.version != "HTTP/1.0") {
        refuse_syntax("the version is neither HTTP/1.1 nor HTTP/1.0");
    }
    if (out.target.size() > limits.max_target_bytes) {
        refuse(414, "target-too-long",
               "expected a path of at most " + std::to_string(limits.max_target_bytes) + " bytes");
    }
    const bool plain = std::all_of(out.target.begin(), out.target.end(),
                                   [](char c) { return c > ' ' && c < 0x7f && c != '#'; });
    if (!plain || out.target.empty() || out.target[0] != '/') {
        refuse_syntax("the path does not begin with / or holds characters that it must not");
    }
    constexpr std::array<std::string_view, 7> kMethods = {"GET",    "HEAD",  "POST",   "PUT",
                                                          "DELETE", "PATCH", "OPTIONS"};
    if (std::find(kMethods.begin(), kMethods.end(), out.method) == kMethods.end()) {
        refuse(501, "unknown-method", "the method is unknown");
    }
}

/// The library decodes %XX in the values of headers, so that it must not find any.
std::string without_percent(const std::string& value) {
    return value.find('%') == std::string::npos ? value : "";
}

/// The headers that the service looks at besides those that it must.
void pass_on(const HeaderMap& headers, std::string& text) {
    constexpr std::array<std::pair<const char*, const char*>, 5> kOnce = {
        {{"authorization", "Authorization"},
         {"idempotency-key", "Idempotency-Key"},
         {"prefer", "Prefer"},
         {"repr-digest", "Repr-Digest"},
         {"last-event-id", "Last-Event-ID"}}};
    for (const auto& [name, as] : kOnce) {
        const std::optional<std::string> value = single(headers, name);
        if (!value) continue;
        if (without_percent(*value).empty()) {
            refuse_syntax(std::string("the header \"") + name + "\" is empty or holds a %");
        }
        text += std::string(as) + ": " + *value + "\r\n";
    }
    // Several ranges are not answered as ranges: a list of them could cost any amount of memory.
    const std::optional<std::string> range = single(headers, "range");
    if (!range || range->find_first_of(",%") != std::string::npos) return;
    text += std::string(kRangeHeader) + ": " + *range + "\r\n";
    if (const std::optional<std::string> tag = single(headers, "if-range")) {
        text += "If-Range: " + without_percent(*tag) + "\r\n";
    }
}

}  // namespace

bool is_upload(std::string_view method, std::string_view target) {
    const std::string_view prefix = kUploadPrefix;
    return method == "PUT" && target.size() > prefix.size() &&
           target.substr(0, prefix.size()) == prefix &&
           target.find_first_of("/?%", prefix.size()) == std::string_view::npos;
}

GuardedHead guard_head(std::string_view head, const GuardLimits& limits,
                       const std::string& request_id) {
    GuardedHead out;
    read_request_line(take_line(head), limits, out);
    const HeaderMap headers = read_headers(head, limits);
    check_host(headers, limits);
    const bool upload = is_upload(out.method, out.target);
    if (upload && limits.max_upload_bytes == 0) {
        refuse(403, "uploads-off", "this service takes no scenes (--max-upload-mib)");
    }
    out.body_bytes =
        body_length(out.method, headers, upload ? limits.max_upload_bytes : limits.max_body_bytes);

    std::string& text = out.for_library;
    text = out.method + " " + out.target + " " + out.version + "\r\nX-Request-Id: " + request_id +
           "\r\nConnection: close\r\nContent-Length: " + std::to_string(out.body_bytes) + "\r\n";
    if (out.body_bytes > 0) {
        const std::optional<std::string> type = single(headers, "content-type");
        const std::string expected = upload ? "application/x-tar" : "application/json";
        check_content_type(type.value_or(""), expected);
        text += "Content-Type: " + expected + "\r\n";
    }
    if (const std::optional<std::string> expect = single(headers, "expect")) {
        if (lower(*expect) != "100-continue") {
            refuse(417, "unknown-expectation", "expected no expectation but 100-continue");
        }
        if (out.body_bytes > 0) text += "Expect: 100-continue\r\n";
    }
    if (const auto at = headers.find("if-none-match"); at != headers.end()) {
        for (const std::string& value : at->second) {
            const std::string tags = without_percent(value);
            if (!tags.empty()) text += "If-None-Match: " + tags + "\r\n";
        }
    }
    out.real_ip = single(headers, "x-real-ip").value_or("").substr(0, kMaxAddressBytes);
    pass_on(headers, text);
    text += "\r\n";
    return out;
}

}  // namespace probebake
