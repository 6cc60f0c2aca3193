// Connection: one client's socket, with an end to everything.
//
// The stream that the HTTP library reads and writes. Its input is a head of bounded size (handed
// over after it was judged, guard.h) and exactly as many bytes of body as were announced; head,
// body and answer each have a time in which they must be through, however slowly a client drips.
// Reads beyond the announced body see the end of the stream, so that nothing that follows is ever
// taken for another request.
#pragma once

#include <httplib.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace probebake {

struct ConnectionLimits {
    size_t max_head_bytes = size_t{16} << 10;
    std::chrono::milliseconds head_time{2000};
    std::chrono::milliseconds body_time{10000};  // per MiB begun
    /// An answer may take this long, and longer by what it has brought through at the least rate.
    std::chrono::milliseconds answer_time{30000};
    uint64_t min_answer_bytes_per_second = uint64_t{64} << 10;
    /// How long is waited, in the end, for the client to have read the answer.
    std::chrono::milliseconds linger_time{1000};
};

class Connection : public httplib::Stream {
  public:
    /// Takes the socket over.
    Connection(int socket, const ConnectionLimits& limits);
    ~Connection() override;
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    /// The head of the request with its blank line; empty where the client closed without a word.
    /// Throws ProblemError where it is too large (431) or too late (408).
    std::string read_head();
    /// What the library is to read: this head, then body_bytes of the client's.
    void feed(std::string head, uint64_t body_bytes);
    void send(std::string_view text);
    /// Tells the client that all was said.
    void hang_up();
    /// The same, and lets it read that: closing with unread input would reset the connection and
    /// take the answer away from it.
    void finish();
    /// Ends it for whoever reads or writes, at once. The one function for other threads.
    void cut_off() const;

    /// Status of the answer, 0 before it began; bytes sent.
    int status() const { return status_; }
    uint64_t bytes_sent() const { return bytes_sent_; }
    const std::string& peer() const { return peer_; }

    bool is_readable() const override;
    bool is_writable() const override;
    ssize_t read(char* into, size_t size) override;
    ssize_t write(const char* from, size_t size) override;
    void get_remote_ip_and_port(std::string& ip, int& port) const override;
    void get_local_ip_and_port(std::string& ip, int& port) const override;
    socket_t socket() const override { return socket_; }

  private:
    using Clock = std::chrono::steady_clock;

    /// Waits until the socket is ready; false when the time is over.
    bool wait(short events, Clock::time_point until) const;
    /// Bytes received, 0 at the end of the stream, -1 after an error or when the time is over.
    ssize_t receive(char* into, size_t size, Clock::time_point until);
    Clock::time_point answer_end() const;

    const int socket_;
    const ConnectionLimits limits_;
    std::string peer_;
    std::string input_;    // received or fed, not yet read
    size_t input_at_ = 0;  // read up to here
    uint64_t body_left_ = 0;
    Clock::time_point body_end_{};
    Clock::time_point answer_begin_{};
    int status_ = 0;
    uint64_t bytes_sent_ = 0;
};

}  // namespace probebake
