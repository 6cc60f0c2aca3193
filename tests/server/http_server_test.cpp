// The sockets of the server itself.
#include "http/http_server.h"

#include <gtest/gtest.h>
#include <netinet/tcp.h>

#include <filesystem>

#include "raw_client.h"
#include "support/sanitized.h"

namespace probebake {
namespace {

int option_of(int socket, int level, int name) {
    int value = -1;
    socklen_t size = sizeof(value);
    ::getsockopt(socket, level, name, &value, &size);
    return value;
}

int port_of(int socket) {
    sockaddr_in address{};
    socklen_t size = sizeof(address);
    if (::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return -1;
    return address.sin_family == AF_INET ? ntohs(address.sin_port) : -1;
}

/// This process's connections that were accepted at the port.
std::vector<int> accepted_at(int port) {
    std::vector<int> sockets;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
        const int socket = std::stoi(entry.path().filename());
        if (port_of(socket) != port || option_of(socket, SOL_SOCKET, SO_ACCEPTCONN) != 0) continue;
        sockets.push_back(socket);
    }
    return sockets;
}

// Without TCP_NODELAY the body of an answer can wait for the client to confirm its head.
TEST(HttpServerTest, AnswersAreSentWithoutDelay) {
    HttpServer::Options options;
    options.port = 0;
    const HttpServer server(
        options,
        [](const httplib::Request&, httplib::Response& response, const httplib::ContentReader*) {
            response.set_content("ok", "text/plain");
        },
        [](const RequestLog&) {});
    test::RawClient client(server.port());
    client.send("GET / HTTP/1.1\r\n");
    std::vector<int> sockets;
    for (int i = 0; i < 1000 && sockets.empty(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        sockets = accepted_at(server.port());
    }
    ASSERT_EQ(sockets.size(), 1U);
    EXPECT_EQ(option_of(sockets[0], IPPROTO_TCP, TCP_NODELAY), 1);
    client.send("Host: localhost\r\n\r\n");
    EXPECT_EQ(test::status_of(client.read_all()), 200);
}

constexpr size_t kLargeBytes = size_t{64} << 20;  // more than sockets hold

/// All of it while it is sent, as an archive is, or what it is asked to take.
void stream_or_take(const httplib::Request&, httplib::Response& response,
                    const httplib::ContentReader* upload) {
    if (upload != nullptr) {
        (*upload)([](const char*, size_t) { return true; });
        return;
    }
    response.set_chunked_content_provider("text/plain", [](size_t, httplib::DataSink& sink) {
        const std::string part(size_t{1} << 16, 'x');
        for (size_t sent = 0; sent < kLargeBytes; sent += part.size()) {
            if (!sink.write(part.data(), part.size())) return false;
        }
        sink.done();
        return true;
    });
}

HttpServer::Options drained_options() {
    HttpServer::Options options;
    options.port = 0;
    options.guard.max_upload_bytes = 2 * kLargeBytes;
    return options;
}

const std::string kGet = "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n";

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

TEST(HttpServerTest, ADrainCutsSlowClientsOff) {
    for (const bool hurried : {false, true}) {
        std::optional<HttpServer> server;
        server.emplace(drained_options(), stream_or_take, [](const RequestLog&) {});
        test::RawClient reader(server->port());
        test::RawClient uploader(server->port());
        reader.send(kGet);
        uploader.send(
            "PUT /v1/scenes/castle HTTP/1.1\r\nHost: localhost\r\n"
            "Content-Type: application/x-tar\r\nContent-Length: 1000000\r\n\r\nabc");
        EXPECT_FALSE(reader.read_some(1000).empty());
        const auto start = std::chrono::steady_clock::now();
        std::jthread hurry;
        if (hurried) {
            hurry = std::jthread([&] {
                std::this_thread::sleep_for(std::chrono::milliseconds(100));
                server->hurry();
            });
        }
        server->drain(std::chrono::seconds(hurried ? 20 : 1));
        EXPECT_EQ(seconds_since(start) < 0.9, hurried) << "they have this time";
        EXPECT_FALSE(test::RawClient(server->port()).connected());
        server.reset();
        EXPECT_LT(seconds_since(start), test::patient(4.0));
        EXPECT_EQ(reader.read_all().find("\r\n0\r\n\r\n"), std::string::npos) << "no end";
    }
}

TEST(HttpServerTest, ADrainWaitsForAnswersThatEndInTime) {
    HttpServer server(drained_options(), stream_or_take, [](const RequestLog&) {});
    test::RawClient client(server.port());
    client.send(kGet);
    std::string text = client.read_some(1000);
    const auto start = std::chrono::steady_clock::now();
    std::jthread reader([&] { text += client.read_all(); });
    server.drain(std::chrono::seconds(60));
    reader.join();
    EXPECT_LT(seconds_since(start), 30.0);
    EXPECT_GT(text.size(), kLargeBytes);
    EXPECT_TRUE(text.ends_with("\r\n0\r\n\r\n"));
}

TEST(HttpServerTest, AnErrorIsLoggedOnceWithItsCause) {
    std::mutex mutex;
    std::vector<RequestLog> lines;
    HttpServer server(
        drained_options(),
        [](const httplib::Request& request, httplib::Response& response,
           const httplib::ContentReader*) {
            if (request.path == "/throws") throw std::runtime_error("the cause");
            response.set_chunked_content_provider(
                "text/plain",
                [](size_t, httplib::DataSink&) -> bool { throw std::runtime_error("broke off"); });
        },
        [&](const RequestLog& line) {
            const std::lock_guard lock(mutex);
            lines.push_back(line);
        });
    const std::string thrown =
        test::exchange(server.port(), "GET /throws HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(test::status_of(thrown), 500);
    EXPECT_EQ(thrown.find("the cause"), std::string::npos);
    const std::string broken =
        test::exchange(server.port(), "GET /breaks HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(test::answers_in(broken), 1U);
    EXPECT_EQ(test::status_of(test::exchange(server.port(), "GET / HTTP/1.1\r\n\r\n")), 400);
    server.drain(std::chrono::seconds(10));
    ASSERT_EQ(lines.size(), 3U);
    EXPECT_EQ(lines[0].cause, "the cause");
    EXPECT_EQ(lines[0].method, "GET");
    EXPECT_EQ(lines[0].target, "/throws");
    EXPECT_EQ(lines[0].status, 500);
    EXPECT_EQ(lines[1].cause, "broke off");
    EXPECT_EQ(lines[1].status, 200);
    EXPECT_EQ(lines[2].cause, "");
}

}  // namespace
}  // namespace probebake
