// Figures for docs/results/reliability.md: submissions and polls per second, beside what the same
// machine's disk and a trivial handler do. Only gross failures fail.
#include <fcntl.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "crash_fixture.h"
#include "server/running_service.h"

namespace probebake {
namespace {

using test::RunningService;
using Clock = std::chrono::steady_clock;

double fsyncs_per_second(const std::filesystem::path& folder) {
    const Descriptor file(::open((folder / "fsync").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
    const std::string block(4096, 'x');
    constexpr int kTimes = 100;
    const double seconds = test::seconds_of([&] {
        for (int i = 0; i < kTimes; ++i) {
            EXPECT_EQ(::pwrite(file.get(), block.data(), block.size(), 0), 4096);
            EXPECT_EQ(::fsync(file.get()), 0);
        }
    });
    return kTimes / seconds;
}

struct Rate {
    double per_second = 0.0;
    double p99_ms = 0.0;
};

/// `clients` threads that call for a while.
Rate rate_of(int clients, std::chrono::milliseconds time, const std::function<bool()>& call) {
    std::mutex mutex;
    std::vector<double> all;
    const auto begin = Clock::now();
    {
        std::vector<std::jthread> threads;
        threads.reserve(static_cast<size_t>(clients));
        for (int i = 0; i < clients; ++i) {
            threads.emplace_back([&] {
                std::vector<double> own;
                while (Clock::now() - begin < time) {
                    const double seconds = test::seconds_of([&] { EXPECT_TRUE(call()); });
                    own.push_back(1000.0 * seconds);
                }
                const std::lock_guard lock(mutex);
                all.insert(all.end(), own.begin(), own.end());
            });
        }
    }
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    std::sort(all.begin(), all.end());
    return {static_cast<double>(all.size()) / seconds, all[all.size() * 99 / 100]};
}

TEST(Throughput, OfSubmissionsAndPolls) {
    RunningService service([](ServiceOptions& options) {
        options.jobs.max_queued = 100'000;
        options.jobs.max_per_tenant = 100'000;
        options.jobs.max_running = 1;
    });
    const test::TempFolder folder;
    const double fsyncs = fsyncs_per_second(folder.path());
    const std::string id = service.submit(test::costly_request(5000, 32));
    service.wait(id, [](const Json& bake) { return bake["progress"]["units_done"] >= 1; });

    const auto get = [&](const std::string& path) {
        return [&service, path] {
            const auto got = service.client().Get(path);
            return got && got->status == 200;
        };
    };
    constexpr std::chrono::milliseconds kTime{3000};
    const Rate trivial = rate_of(8, kTime, get("/healthz"));
    const Rate polls = rate_of(8, kTime, get("/v1/bakes/" + id));
    std::string body = test::net_request(1).dump();
    const auto submit = [&] {
        const auto got = service.client().Post("/v1/bakes", body, "application/json");
        return got && got->status == 202;
    };
    const Rate one = rate_of(1, kTime, submit);
    const Rate many = rate_of(16, kTime, submit);
    EXPECT_EQ(service.state(id), "RUNNING") << "the bake went on all the time";
    std::cout << "during a bake: " << trivial.per_second << " trivial answers/s (p99 "
              << trivial.p99_ms << " ms), " << polls.per_second << " status polls/s (p99 "
              << polls.p99_ms << " ms, ratio " << polls.per_second / trivial.per_second << "); "
              << fsyncs << " fsyncs/s, " << one.per_second << " durable submissions/s of one client"
              << " (ratio " << one.per_second / fsyncs << "), " << many.per_second
              << " of 16 (ratio " << many.per_second / fsyncs << ", p99 " << many.p99_ms
              << " ms)\n";
    service.post("/v1/bakes/" + id + ":cancel");
    if (test::thread_sanitized()) return;  // rates are those of the sanitizer
    EXPECT_GT(polls.per_second, 0.2 * trivial.per_second);
    EXPECT_GT(many.per_second, one.per_second);
}

}  // namespace
}  // namespace probebake
