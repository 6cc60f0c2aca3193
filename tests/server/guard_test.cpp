#include "http/guard.h"

#include <gtest/gtest.h>

#include "http/problem.h"

namespace probebake {
namespace {

/// "200", or the status that a head is refused with.
int judged(const std::string& head) {
    try {
        guard_head(head, {}, "r-1");
    } catch (const ProblemError& error) {
        return error.problem().status;
    }
    return 200;
}

std::string get(const std::string& headers, const std::string& target = "/healthz") {
    return "GET " + target + " HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n";
}

std::string post(const std::string& headers) {
    return "POST /v1/bakes HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n";
}

TEST(Guard, PassesOnOnlyWhatItWroteItself) {
    const GuardedHead head = guard_head(
        get("X-Request-Id: forged\r\nRange: bytes=0-1,0-2,0-3\r\nIf-Range: x\r\nCookie: a\r\n"
            "If-None-Match: \"abc\"\r\nContent-Length: 0\r\nREMOTE_ADDR: 1.2.3.4\r\n",
            "/v1/bakes?page_size=5"),
        {}, "r-1");
    EXPECT_EQ(head.method, "GET");
    EXPECT_EQ(head.target, "/v1/bakes?page_size=5");
    EXPECT_EQ(head.for_library,
              "GET /v1/bakes?page_size=5 HTTP/1.1\r\nX-Request-Id: r-1\r\nConnection: close\r\n"
              "Content-Length: 0\r\nIf-None-Match: \"abc\"\r\n\r\n");
}

TEST(Guard, ABodyHasATypeAndALength) {
    const GuardedHead head = guard_head(
        post("Content-Type: application/JSON; charset=utf-8\r\nContent-Length: 12\r\n"), {}, "r-1");
    EXPECT_EQ(head.body_bytes, 12U);
    EXPECT_NE(head.for_library.find("Content-Type: application/json\r\n"), std::string::npos);
    EXPECT_NE(head.for_library.find("Content-Length: 12\r\n"), std::string::npos);
    EXPECT_EQ(judged(post("Content-Type: text/plain\r\nContent-Length: 12\r\n")), 415);
    EXPECT_EQ(judged(post("Content-Length: 12\r\n")), 415);
    EXPECT_EQ(judged(post("Content-Type: multipart/form-data; boundary=x\r\n"
                          "Content-Length: 12\r\n")),
              415);
    EXPECT_EQ(judged(post("")), 200) << "a POST without a length has no body";
}

TEST(Guard, RefusesDoubtfulBodies) {
    const std::string type = "Content-Type: application/json\r\n";
    EXPECT_EQ(judged(post(type + "Transfer-Encoding: chunked\r\n")), 411);
    EXPECT_EQ(judged(post(type + "Transfer-Encoding: chunked\r\nContent-Length: 4\r\n")), 411);
    EXPECT_EQ(judged(post(type + "transfer-encoding: identity\r\n")), 411);
    EXPECT_EQ(judged(get("Transfer-Encoding: chunked\r\n")), 411);
    EXPECT_EQ(judged(post(type + "Content-Encoding: gzip\r\nContent-Length: 4\r\n")), 415);
    EXPECT_EQ(judged(post(type + "Content-Length: 4\r\nContent-Length: 4\r\n")), 400);
    EXPECT_EQ(judged(post(type + "Content-Length: 4\r\ncontent-length: 40\r\n")), 400);
    for (const char* length : {"", "-1", "+4", "0x10", "4, 4", "4 4", "4.0", "1e3", "%34"}) {
        EXPECT_EQ(judged(post(type + "Content-Length: " + length + "\r\n")), 400) << length;
    }
    EXPECT_EQ(judged(post(type + "Content-Length: 1048576\r\n")), 200);
    EXPECT_EQ(judged(post(type + "Content-Length: 1048577\r\n")), 413);
    EXPECT_EQ(judged(post(type + "Content-Length: 18446744073709551617\r\n")), 413);
    EXPECT_EQ(judged(post(type + "Content-Length: " + std::string(5000, '9') + "\r\n")), 413);
    EXPECT_EQ(judged(get("Content-Length: 5\r\n")), 400);
    EXPECT_EQ(judged("HEAD / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\n"), 400);
}

TEST(Guard, RefusesForeignHosts) {
    const auto with_host = [](const std::string& host) {
        return judged("GET / HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    };
    for (const char* host : {"localhost", "LOCALHOST:8080", "127.0.0.1:1", "[::1]", "[::1]:8080"}) {
        EXPECT_EQ(with_host(host), 200) << host;
    }
    for (const char* host : {"example.org", "localhost.example.org", "127.0.0.1.example.org", "",
                             "[::2]", "evil@localhost"}) {
        EXPECT_EQ(with_host(host), 421) << host;
    }
    EXPECT_EQ(with_host("localhost:8080x"), 400);
    GuardLimits limits;
    limits.hosts.emplace_back("Bakes.Example.ORG");
    EXPECT_NO_THROW(
        guard_head("GET / HTTP/1.1\r\nHost: bakes.EXAMPLE.org:80\r\n\r\n", limits, "r-1"));
    EXPECT_EQ(judged("GET / HTTP/1.1\r\n\r\n"), 400);
    EXPECT_EQ(judged("GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n"), 400);
}

TEST(Guard, RefusesWhatIsNotPlainHttp) {
    for (const std::string& head : {std::string("GET / HTTP/2.0\r\nHost: localhost\r\n\r\n"),
                                    std::string("GET /\r\nHost: localhost\r\n\r\n"),
                                    std::string("GET  HTTP/1.1\r\nHost: localhost\r\n\r\n"),
                                    std::string("GET / HTTP/1.1\nHost: localhost\n\n\r\n\r\n"),
                                    std::string("GET / HTTP/1.1\r\nHost: localhost\nX: y\r\n\r\n"),
                                    std::string("GET / HTTP/1.1\r\nHost: localhost\rX: y\r\n\r\n"),
                                    std::string("G\x01T / HTTP/1.1\r\nHost: localhost\r\n\r\n"),
                                    std::string("\r\nGET / HTTP/1.1\r\nHost: localhost\r\n\r\n"),
                                    get("no colon here\r\n"),
                                    get(": no name\r\n"),
                                    get("Name : space before the colon\r\n"),
                                    get(" folded: line\r\n"),
                                    get("X: a\x01z\r\n"),
                                    get(std::string("X: a\0z\r\n", 8)),
                                    get("", "http://localhost/healthz"),
                                    get("", "*"),
                                    get("", "/a b"),
                                    get("", "/a\x7f"),
                                    get("", "/\xc3\xa4"),
                                    get("", "/a#b")}) {
        EXPECT_EQ(judged(head), 400) << head;
    }
    EXPECT_EQ(judged(get("", "/" + std::string(2048, 'a'))), 414);
    EXPECT_EQ(judged("BREW / HTTP/1.1\r\nHost: localhost\r\n\r\n"), 501);
    EXPECT_EQ(judged("TRACE / HTTP/1.1\r\nHost: localhost\r\n\r\n"), 501);
    EXPECT_EQ(judged(get("Expect: 200-ok\r\n")), 417);
}

TEST(Guard, OnlyAPlainNameMakesAnUpload) {
    GuardLimits limits;
    limits.max_upload_bytes = uint64_t{64} << 20;
    const auto put = [&](const std::string& target, const std::string& type) {
        try {
            return guard_head("PUT " + target + " HTTP/1.1\r\nHost: localhost\r\nContent-Type: " +
                                  type + "\r\nContent-Length: 2000000\r\n\r\n",
                              limits, "r-1")
                .body_bytes;
        } catch (const ProblemError& error) {
            return static_cast<uint64_t>(error.problem().status);
        }
    };
    EXPECT_EQ(put("/v1/scenes/castle", "application/x-tar"), 2000000U);
    // The library would find other paths in these, whose bodies it holds in memory.
    for (const char* target : {"/v1/scenes/a%2Fb", "/v1/scenes/%61", "/v1/scenes/a?b",
                               "/v1/scenes/a/b", "/v1/scenes/", "/v1/scenes"}) {
        EXPECT_EQ(put(target, "application/x-tar"), 413U) << target;
        EXPECT_EQ(put(target, "application/json"), 413U) << target;
    }
}

TEST(Guard, TheVersionIsTheClients) {
    const GuardedHead head = guard_head("GET / HTTP/1.0\r\nHost: localhost\r\n\r\n", {}, "r-1");
    EXPECT_EQ(head.for_library.rfind("GET / HTTP/1.0\r\n", 0), 0U) << head.for_library;
}

TEST(Guard, CountsHeaders) {
    std::string headers;
    for (int i = 0; i < 63; ++i) headers += "X: y\r\n";
    EXPECT_EQ(judged(get(headers)), 200);
    EXPECT_EQ(judged(get(headers + "X: y\r\n")), 431);
}

TEST(Guard, TheLibraryFindsNothingToDecode) {
    const GuardedHead head =
        guard_head(get("If-None-Match: \"a%0d%0aSet-Cookie: x\"\r\n"), {}, "r-1");
    EXPECT_EQ(head.for_library.find('%'), std::string::npos);
}

}  // namespace
}  // namespace probebake
