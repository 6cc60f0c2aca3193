#include "engine/render_pool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace probebake {
namespace {

using namespace std::chrono_literals;

TEST(RenderPool, RunsEveryUnitOnceOnItsOwnThreads) {
    for (const int threads : {1, 2, 7}) {
        RenderPool pool(threads);
        std::vector<std::atomic<int>> runs(500);
        std::mutex mutex;
        std::set<std::thread::id> ids;
        std::atomic<int> at_once{0};
        std::atomic<int> most{0};
        pool.for_each(runs.size(), [&](size_t i) {
            const int now = ++at_once;
            int seen = most;
            while (now > seen && !most.compare_exchange_weak(seen, now)) {
            }
            ++runs[i];
            std::this_thread::sleep_for(100us);
            {
                const std::lock_guard lock(mutex);
                ids.insert(std::this_thread::get_id());
            }
            --at_once;
        });
        for (const auto& count : runs) ASSERT_EQ(count, 1);
        EXPECT_LE(most, threads);
        EXPECT_FALSE(ids.contains(std::this_thread::get_id()));
    }
}

TEST(RenderPool, NestedLoopsUseThreadsWithoutUnits) {
    RenderPool pool(4);
    std::mutex mutex;
    std::set<std::thread::id> ids;
    pool.run([&] {
        tbb::parallel_for(0, 400, [&](int) {
            std::this_thread::sleep_for(500us);
            const std::lock_guard lock(mutex);
            ids.insert(std::this_thread::get_id());
        });
    });
    EXPECT_GT(ids.size(), 1u);
}

TEST(RenderPool, AShortLaneDoesNotWaitForALongOne) {
    RenderPool pool(2);
    std::atomic<int> long_done{0};
    std::jthread long_job([&] {
        pool.for_each(400, [&](size_t) {
            std::this_thread::sleep_for(2ms);
            ++long_done;
        });
    });
    while (long_done < 4) std::this_thread::sleep_for(1ms);
    const int before = long_done;
    pool.for_each(10, [&](size_t) { std::this_thread::sleep_for(2ms); });
    // In turn: about as many units of the long lane as of the short one in the meantime.
    EXPECT_LT(long_done - before, 40);
}

TEST(RenderPool, TheFirstFailureEndsALaneAndNoOther) {
    RenderPool pool(2);
    std::atomic<int> started{0};
    const auto failing = [&] {
        pool.for_each(1000, [&](size_t i) {
            ++started;
            if (i == 3) throw std::runtime_error("unit 3");
        });
    };
    std::atomic<int> others{0};
    std::jthread other([&] {
        pool.for_each(100, [&](size_t) {
            std::this_thread::sleep_for(200us);
            ++others;
        });
    });
    try {
        failing();
        FAIL() << "no exception";
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "unit 3");
    }
    // Empty units: while the failing thread is off the processor the other starts some more.
    EXPECT_LT(started, 500) << "of 1000";
    other.join();
    EXPECT_EQ(others, 100);
}

TEST(RenderPool, WorkersHaveALowerPriority) {
    RenderPool pool(2);
    std::atomic<int> lowest{20};
    pool.for_each(50, [&](size_t) {
        const int niceness = ::getpriority(PRIO_PROCESS, 0);
        int seen = lowest;
        while (niceness < seen && !lowest.compare_exchange_weak(seen, niceness)) {
        }
    });
    EXPECT_GE(lowest, 10);
    const int own = ::getpriority(PRIO_PROCESS, 0);
    EXPECT_TRUE(own < lowest || own >= 10) << "unless the tests themselves run at a low one";
}

TEST(RenderPool, NothingToDo) {
    RenderPool pool(1);
    pool.for_each(0, [](size_t) { FAIL(); });
}

}  // namespace
}  // namespace probebake
