// ConnectionPool: a bounded number of threads for a bounded number of clients.
//
// `workers` threads each serve one connection at a time; up to `max_waiting` accepted connections
// wait for them. Beyond that a connection is refused: it is told so at once, and one more thread
// sees to it that the answer arrives before the socket is closed; where even this thread is behind,
// the socket is just closed. Nothing ever waits on the thread that accepts.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace probebake {

class ConnectionPool {
  public:
    struct Options {
        size_t workers = 32;
        size_t max_waiting = 128;
        size_t max_refusals_waiting = 64;
    };
    /// Both take the socket over and do not throw. `refuse` does not wait either: it returns the
    /// rest of its work, which may be dropped.
    struct Work {
        std::function<void(int socket)> serve;
        std::function<std::function<void()>(int socket)> refuse;
    };

    ConnectionPool(const Options& options, Work work);
    ~ConnectionPool();
    ConnectionPool(const ConnectionPool&) = delete;
    ConnectionPool& operator=(const ConnectionPool&) = delete;

    void add(int socket);
    /// Serves what waits, takes nothing more, and ends the threads.
    void stop();

  private:
    struct Lane {
        std::deque<std::function<void()>> work;
        std::condition_variable grew;
    };
    void run(Lane& lane);

    const Options options_;
    const Work work_;

    std::mutex mutex_;
    // Guarded by mutex_:
    Lane served_;
    Lane refused_;
    bool stopping_ = false;

    std::vector<std::jthread> threads_;
};

}  // namespace probebake
