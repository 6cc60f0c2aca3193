// A client that says what no decent client would: bytes on a socket.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <string>
#include <string_view>
#include <utility>

namespace probebake::test {

class RawClient {
  public:
    /// From 127.0.0.`from` to 127.0.0.1.
    explicit RawClient(int port, uint32_t from = 1)
        : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        const auto loopback = [](uint32_t last, int port_there) {
            sockaddr_in address{};
            address.sin_family = AF_INET;
            address.sin_port = htons(static_cast<uint16_t>(port_there));
            address.sin_addr.s_addr = htonl(INADDR_LOOPBACK - 1 + last);
            return address;
        };
        const sockaddr_in here = loopback(from, 0);
        const auto* bound = reinterpret_cast<const sockaddr*>(&here);
        if (from != 1 && ::bind(socket_, bound, sizeof(here)) != 0) return;  // not connected
        const sockaddr_in there = loopback(1, port);
        connected_ =
            ::connect(socket_, reinterpret_cast<const sockaddr*>(&there), sizeof(there)) == 0;
    }
    ~RawClient() {
        if (socket_ >= 0) ::close(socket_);
    }
    RawClient(RawClient&& other) noexcept
        : socket_(std::exchange(other.socket_, -1)), connected_(other.connected_) {}
    RawClient(const RawClient&) = delete;
    RawClient& operator=(const RawClient&) = delete;

    bool connected() const { return connected_; }
    /// False once the service has closed its end.
    bool send(std::string_view bytes) {
        while (!bytes.empty()) {
            const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
            if (n < 0 && errno == EINTR) continue;
            if (n <= 0) return false;
            bytes.remove_prefix(static_cast<size_t>(n));
        }
        return true;
    }
    /// Everything until the service closes, or nothing more for that long.
    std::string read_all(std::chrono::milliseconds patience = std::chrono::seconds(10)) {
        std::string text;
        std::array<char, 65536> buffer{};
        for (;;) {
            pollfd ready{socket_, POLLIN, 0};
            if (::poll(&ready, 1, static_cast<int>(patience.count())) <= 0) return text;
            const ssize_t n = ::recv(socket_, buffer.data(), buffer.size(), 0);
            if (n <= 0) return text;
            text.append(buffer.data(), static_cast<size_t>(n));
        }
    }
    /// Reads at most so many bytes.
    std::string read_some(size_t most) {
        std::string text(most, '\0');
        const ssize_t n = ::recv(socket_, text.data(), most, 0);
        text.resize(n > 0 ? static_cast<size_t>(n) : 0);
        return text;
    }

  private:
    int socket_;
    bool connected_ = false;
};

/// A port of 127.0.0.1 that is free at this moment.
inline int free_port() {
    const int any = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    auto* const at = reinterpret_cast<sockaddr*>(&address);
    socklen_t size = sizeof(address);
    EXPECT_EQ(::bind(any, at, size), 0);
    EXPECT_EQ(::getsockname(any, at, &size), 0);
    ::close(any);
    return ntohs(address.sin_port);
}

/// What comes back for these bytes.
inline std::string exchange(int port, std::string_view bytes) {
    RawClient client(port);
    EXPECT_TRUE(client.connected());
    client.send(bytes);
    return client.read_all();
}

/// The status of the first answer in a text, 0 where there is none.
inline int status_of(const std::string& text) {
    return text.rfind("HTTP/1.1 ", 0) == 0 ? std::stoi(text.substr(9, 3)) : 0;
}

inline size_t answers_in(const std::string& text) {
    size_t count = 0;
    for (size_t at = text.find("HTTP/1.1 "); at != std::string::npos;
         at = text.find("HTTP/1.1 ", at + 1)) {
        ++count;
    }
    return count;
}

}  // namespace probebake::test
