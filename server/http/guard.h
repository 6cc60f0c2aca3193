// The guard: every request's head is judged here before the HTTP library sees a byte of it.
//
// cpp-httplib 0.11.4 reads chunked and compressed bodies past its own limit, takes any number of
// headers, misreads lengths that are repeated or malformed, and answers Range headers wrongly
// (docs/service.md, "What is refused before it is read"). So the head is parsed strictly, refused
// where anything in it is doubtful, and the library is handed a head written anew: the request
// line, the request's number, and the few headers that the service looks at. In particular there
// is always exactly one Content-Length and never a Range (a single one comes as X-Range).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace probebake {

/// A single range, as the guard passes it on: under its own name the library would answer it.
inline constexpr const char* kRangeHeader = "X-Range";

struct GuardLimits {
    size_t max_head_bytes = size_t{16} << 10;
    size_t max_target_bytes = 2048;
    size_t max_headers = 64;
    uint64_t max_body_bytes = uint64_t{1} << 20;
    /// Of a scene (is_upload); 0: none is taken.
    uint64_t max_upload_bytes = 0;
    /// Host names that clients may address, without port.
    std::vector<std::string> hosts = {"localhost", "127.0.0.1", "[::1]"};
};

struct GuardedHead {
    std::string method;
    std::string target;
    std::string version;  // HTTP/1.0 or HTTP/1.1
    uint64_t body_bytes = 0;
    std::string real_ip;      // what X-Real-IP says; only a proxy of ours is to be believed
    std::string for_library;  // the head written anew, with its blank line
};

/// The requests that bring a scene, a tar instead of JSON: PUT on these paths. The name is a plain
/// one: the library decodes %XX before it looks for who reads the body, and would hold a body whole
/// in memory that nobody is there to read bit by bit.
inline constexpr const char* kUploadPattern = "/v1/scenes/[^/]+";
inline constexpr const char* kUploadPrefix = "/v1/scenes/";
bool is_upload(std::string_view method, std::string_view target);

/// The head of a request up to and including the blank line. Throws ProblemError.
GuardedHead guard_head(std::string_view head, const GuardLimits& limits,
                       const std::string& request_id);

}  // namespace probebake
