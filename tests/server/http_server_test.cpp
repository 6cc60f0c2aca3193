// The sockets of the server itself.
#include "http/http_server.h"

#include <gtest/gtest.h>
#include <netinet/tcp.h>

#include <filesystem>

#include "raw_client.h"

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

}  // namespace
}  // namespace probebake
