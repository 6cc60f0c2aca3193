#include "http/connection.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "http/problem.h"

namespace probebake {
namespace {

std::string peer_of(int socket) {
    sockaddr_storage address{};
    socklen_t size = sizeof(address);
    std::array<char, INET6_ADDRSTRLEN> text{};
    if (::getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return "";
    const void* ip = nullptr;
    if (address.ss_family == AF_INET) {
        ip = &reinterpret_cast<const sockaddr_in&>(address).sin_addr;
    } else if (address.ss_family == AF_INET6) {
        ip = &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
    } else {
        return "";
    }
    return ::inet_ntop(address.ss_family, ip, text.data(), text.size()) == nullptr ? ""
                                                                                   : text.data();
}

}  // namespace

Connection::Connection(int socket, const ConnectionLimits& limits)
    : socket_(socket), limits_(limits), peer_(peer_of(socket)) {}

Connection::~Connection() { ::close(socket_); }

bool Connection::wait(short events, Clock::time_point until) const {
    for (;;) {
        const auto left =
            std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
        if (left <= 0) return false;
        pollfd ready{socket_, events, 0};
        const int n = ::poll(&ready, 1, static_cast<int>(std::min<int64_t>(left, 60'000)));
        if (n > 0) return true;
        if (n < 0 && errno != EINTR) return false;
    }
}

ssize_t Connection::receive(char* into, size_t size, Clock::time_point until) {
    for (;;) {
        const ssize_t n = ::recv(socket_, into, size, MSG_DONTWAIT);
        if (n >= 0) return n;
        if (errno != EAGAIN && errno != EINTR) return -1;
        if (!wait(POLLIN, until)) return -1;
    }
}

std::string Connection::read_head() {
    const Clock::time_point end = Clock::now() + limits_.head_time;
    std::array<char, 4096> buffer{};
    for (;;) {
        const ssize_t n = receive(buffer.data(), buffer.size(), end);
        if (n == 0) return {};
        if (n < 0) {
            if (input_.empty()) return {};
            throw ProblemError({.status = 408,
                                .code = "too-slow",
                                .detail = "the head of the request did not arrive in time"});
        }
        // The blank line may begin in what came before.
        const size_t from = input_.size() < 3 ? 0 : input_.size() - 3;
        input_.append(buffer.data(), static_cast<size_t>(n));
        const size_t blank = input_.find("\r\n\r\n", from);
        const size_t head_bytes = blank == std::string::npos ? input_.size() : blank + 4;
        if (head_bytes > limits_.max_head_bytes) {
            throw ProblemError({.status = 431,
                                .code = "head-too-large",
                                .detail = "expected a request line and headers of at most " +
                                          std::to_string(limits_.max_head_bytes) + " bytes"});
        }
        if (blank != std::string::npos) {
            std::string head = input_.substr(0, head_bytes);
            input_.erase(0, head_bytes);
            return head;
        }
    }
}

void Connection::feed(std::string head, uint64_t body_bytes) {
    // Of the body, what came together with the head; what comes behind it nobody reads.
    const uint64_t here = std::min<uint64_t>(input_.size(), body_bytes);
    input_ = std::move(head) + input_.substr(0, here);
    input_at_ = 0;
    body_left_ = body_bytes - here;
    const auto mebibytes = static_cast<int64_t>(body_bytes >> 20) + 1;
    body_end_ = Clock::now() + limits_.body_time * mebibytes;
}

bool Connection::is_readable() const {
    if (input_at_ < input_.size() || body_left_ == 0) return true;
    return wait(POLLIN, body_end_);
}

ssize_t Connection::read(char* into, size_t size) {
    if (input_at_ < input_.size()) {
        const size_t n = std::min(size, input_.size() - input_at_);
        std::memcpy(into, input_.data() + input_at_, n);
        input_at_ += n;
        return static_cast<ssize_t>(n);
    }
    if (body_left_ == 0) return 0;
    const ssize_t n = receive(into, std::min<uint64_t>(size, body_left_), body_end_);
    if (n > 0) body_left_ -= static_cast<uint64_t>(n);
    return n;
}

Connection::Clock::time_point Connection::answer_end() const {
    return answer_begin_ + limits_.answer_time +
           std::chrono::milliseconds(1000 * bytes_sent_ / limits_.min_answer_bytes_per_second);
}

bool Connection::is_writable() const {
    return answer_begin_ == Clock::time_point{} || wait(POLLOUT, answer_end());
}

ssize_t Connection::write(const char* from, size_t size) {
    if (answer_begin_ == Clock::time_point{}) answer_begin_ = Clock::now();
    for (;;) {
        const ssize_t n = ::send(socket_, from, size, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (n >= 0) {
            // "HTTP/1.1 200 OK"; an answer "100 Continue" may come before the one that counts.
            constexpr std::string_view kVersion = "HTTP/1.1 ";
            if ((bytes_sent_ == 0 || status_ == 100) && n >= 12 &&
                std::string_view(from, kVersion.size()) == kVersion) {
                status_ = 100 * (from[9] - '0') + 10 * (from[10] - '0') + (from[11] - '0');
            }
            bytes_sent_ += static_cast<uint64_t>(n);
            return n;
        }
        if (errno != EAGAIN && errno != EINTR) return -1;
        if (!wait(POLLOUT, answer_end())) return -1;
    }
}

void Connection::send(std::string_view text) {
    while (!text.empty()) {
        const ssize_t n = write(text.data(), text.size());
        if (n <= 0) return;  // the client has gone
        text.remove_prefix(static_cast<size_t>(n));
    }
}

void Connection::hang_up() { ::shutdown(socket_, SHUT_WR); }

void Connection::cut_off() const { ::shutdown(socket_, SHUT_RDWR); }

void Connection::finish() {
    hang_up();
    const Clock::time_point end = Clock::now() + limits_.linger_time;
    std::array<char, 16384> ignored{};
    while (Clock::now() < end && receive(ignored.data(), ignored.size(), end) > 0) {
    }
}

void Connection::get_remote_ip_and_port(std::string& ip, int& port) const {
    ip = peer_;
    port = 0;
}

// The library only copies it into the headers that it shows to handlers; ours do not look.
void Connection::get_local_ip_and_port(std::string& ip, int& port) const {
    ip.clear();
    port = 0;
}

}  // namespace probebake
