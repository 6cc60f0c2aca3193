#include "engine/render_pool.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

namespace probebake {
namespace {

/// Of 19, the lowest: the service's threads go first, other programs are not starved either.
constexpr int kRenderNiceness = 10;

}  // namespace

RenderPool::LowPriority::LowPriority(tbb::task_arena& arena) : tbb::task_scheduler_observer(arena) {
    observe(true);
}

RenderPool::LowPriority::~LowPriority() { observe(false); }

void RenderPool::LowPriority::on_scheduler_entry(bool is_worker) {
    // 0 is the calling thread; a failure leaves it at its priority, which is no harm.
    if (is_worker && ::getpriority(PRIO_PROCESS, 0) < kRenderNiceness) {
        ::setpriority(PRIO_PROCESS, 0, kRenderNiceness);
    }
}

RenderPool::RenderPool(int threads)
    : threads_(threads),
      // The limit counts the calling thread, which does no work here.
      allow_threads_(tbb::global_control::max_allowed_parallelism,
                     static_cast<size_t>(threads) + 1),
      arena_(threads, 0),
      low_priority_(arena_) {}

RenderPool::~RenderPool() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [&] { return running_ == 0; });
}

void RenderPool::for_each(size_t count, const std::function<void(size_t)>& unit) {
    Lane lane{.count = count, .unit = &unit};
    std::unique_lock lock(mutex_);
    lanes_.push_back(&lane);
    start_units();
    ended_.wait(lock, [&] { return lane.finished(); });
    lanes_.erase(std::remove(lanes_.begin(), lanes_.end(), &lane), lanes_.end());
    if (lane.failure) std::rethrow_exception(lane.failure);
}

void RenderPool::run(const std::function<void()>& work) {
    for_each(1, [&](size_t) { work(); });
}

void RenderPool::start_units() {
    while (running_ < threads_) {
        const auto at = std::find_if(lanes_.begin(), lanes_.end(),
                                     [](const Lane* lane) { return lane->waiting(); });
        if (at == lanes_.end()) return;
        Lane* const lane = *at;
        lanes_.erase(at);
        lanes_.push_back(lane);  // the others come first now
        const size_t index = lane->next++;
        ++lane->under_way;
        ++running_;
        arena_.enqueue([this, lane, index] { run_unit(*lane, index); });
    }
}

void RenderPool::run_unit(Lane& lane, size_t index) {
    std::exception_ptr failure;
    try {
        // Isolated: while it waits for its own tiles it must not begin another unit.
        tbb::this_task_arena::isolate([&] { (*lane.unit)(index); });
    } catch (...) {
        failure = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    if (!lane.failure) lane.failure = std::move(failure);
    --lane.under_way;
    --running_;
    start_units();
    ended_.notify_all();
}

}  // namespace probebake
