// RenderPool: the one pool of threads for all rendering, shared fairly by jobs.
//
// One oneTBB arena of `threads` workers at a lower priority than the service's own threads. A lane
// is a job's place in it: units of different lanes are started in turn, one at a time, so that a
// job of ten thousand probes does not hold up one of eight. A unit may use tbb::parallel_for
// inside; threads without a unit of their own then help.
//
//   lanes:   A: a3 a4 a5 …      B: b1 b2      C: c7 …
//   started: … a3 b1 c7 a4 b2 c8 a5 c9 …      never more than `threads` at once
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>

namespace probebake {

class RenderPool {
  public:
    /// threads ≥ 1.
    explicit RenderPool(int threads);
    ~RenderPool();
    RenderPool(const RenderPool&) = delete;
    RenderPool& operator=(const RenderPool&) = delete;

    int threads() const { return threads_; }

    /// Calls unit(i) for all i < count on the pool, in ascending order of start, as one lane; waits
    /// for them. When a unit throws, no further one is started and the first exception is thrown
    /// here once those under way have ended. Not to be called from a unit.
    void for_each(size_t count, const std::function<void(size_t)>& unit);

    /// The same for a single piece of work.
    void run(const std::function<void()>& work);

  private:
    /// Lives in for_each, which waits until no unit of it is under way: the arena may let go of a
    /// task long after its unit has ended.
    struct Lane {
        size_t count = 0;
        const std::function<void(size_t)>* unit = nullptr;
        size_t next = 0;
        size_t under_way = 0;
        std::exception_ptr failure;

        bool waiting() const { return next < count && !failure; }
        bool finished() const { return under_way == 0 && !waiting(); }
    };
    /// Lowers the priority of every worker that enters the arena.
    class LowPriority : public tbb::task_scheduler_observer {
      public:
        explicit LowPriority(tbb::task_arena& arena);
        ~LowPriority() override;
        void on_scheduler_entry(bool is_worker) override;
    };

    void start_units();  // with mutex_ held
    void run_unit(Lane& lane, size_t index);

    const int threads_;
    tbb::global_control allow_threads_;
    tbb::task_arena arena_;
    LowPriority low_priority_;

    std::mutex mutex_;
    // Guarded by mutex_:
    std::condition_variable ended_;
    std::deque<Lane*> lanes_;  // the next one to start a unit of stands in front
    int running_ = 0;
};

}  // namespace probebake
