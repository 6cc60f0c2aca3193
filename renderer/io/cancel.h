// Stopping work that is under way.
#pragma once

#include <atomic>
#include <stdexcept>

namespace probebake {

/// Thrown by a render whose token was cancelled; nothing of it is to be used.
class Cancelled : public std::runtime_error {
  public:
    Cancelled() : std::runtime_error("cancelled") {}
};

/// Set from any thread, looked at once per tile.
class CancelToken {
  public:
    void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
    bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }
    void throw_if_cancelled() const {
        if (cancelled()) throw Cancelled();
    }

  private:
    std::atomic<bool> cancelled_{false};
};

}  // namespace probebake
