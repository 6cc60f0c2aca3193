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
    // The first thread waits for a second one, however late a busy machine lets it run.
    const auto give_up = std::chrono::steady_clock::now() + 60s;
    const auto alone = [&] {
        const std::lock_guard lock(mutex);
        ids.insert(std::this_thread::get_id());
        return ids.size() < 2;
    };
    pool.run([&] {
        tbb::parallel_for(0, 400, [&](int) {
            while (alone() && std::chrono::steady_clock::now() < give_up) {
                std::this_thread::sleep_for(500us);
            }
        });
    });
    EXPECT_GT(ids.size(), 1U);
}

TEST(RenderPool, AShortLaneDoesNotWaitForALongOne) {
    RenderPool pool(1);          // the order of starts is that of runs
    constexpr int kLong = 5000;  // 10 s
    constexpr int kShort = 10;
    std::atomic<int> long_begun{0};
    std::atomic<bool> short_done{false};
    std::jthread long_job([&] {
        pool.for_each(kLong, [&](size_t) {
            ++long_begun;
            if (!short_done) std::this_thread::sleep_for(2ms);
        });
    });
    while (long_begun < 4) std::this_thread::sleep_for(1ms);
    int first = 0;
    int last = 0;
    pool.for_each(kShort, [&](size_t i) {
        if (i == 0) first = long_begun;
        if (i + 1 == kShort) last = long_begun;
        std::this_thread::sleep_for(2ms);
    });
    short_done = true;
    // Counted in units, not in seconds: begun in turn, whatever the processor does meanwhile.
    EXPECT_LT(first, kLong) << "waited for the whole of it";
    EXPECT_LE(last - first, kShort);
}

TEST(RenderPool, TheFirstFailureEndsALaneAndNoOther) {
    RenderPool pool(2);
    std::atomic<int> started{0};
    const auto failing = [&] {
        pool.for_each(1000, [&](size_t i) {
            ++started;
            if (i == 3) throw std::runtime_error("unit 3");
            std::this_thread::sleep_for(5ms);
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
    // The other thread goes on for as long as the failing one is off the processor: 2 s at most.
    EXPECT_LT(started, 400) << "of 1000";
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
