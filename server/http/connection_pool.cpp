#include "http/connection_pool.h"

#include <utility>

namespace probebake {

ConnectionPool::ConnectionPool(const Options& options, Work work)
    : options_(options), work_(std::move(work)) {
    for (size_t i = 0; i < options_.workers; ++i) {
        threads_.emplace_back([this] { run(served_); });
    }
    threads_.emplace_back([this] { run(refused_); });
}

ConnectionPool::~ConnectionPool() { stop(); }

void ConnectionPool::add(int socket) {
    {
        const std::lock_guard lock(mutex_);
        if (!stopping_ && served_.work.size() < options_.max_waiting) {
            served_.work.emplace_back([this, socket] { work_.serve(socket); });
            served_.grew.notify_one();
            return;
        }
    }
    std::function<void()> rest = work_.refuse(socket);
    const std::lock_guard lock(mutex_);
    if (stopping_ || refused_.work.size() >= options_.max_refusals_waiting) return;
    refused_.work.push_back(std::move(rest));
    refused_.grew.notify_one();
}

void ConnectionPool::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        served_.grew.notify_all();
        refused_.grew.notify_all();
    }
    threads_.clear();
}

void ConnectionPool::run(Lane& lane) {
    std::unique_lock lock(mutex_);
    for (;;) {
        lane.grew.wait(lock, [&] { return !lane.work.empty() || stopping_; });
        if (lane.work.empty()) return;
        {
            const std::function<void()> next = std::move(lane.work.front());
            lane.work.pop_front();
            lock.unlock();
            next();
        }
        lock.lock();
    }
}

}  // namespace probebake
