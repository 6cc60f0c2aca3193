// C13: a service under mixed work for a while takes no more and more memory or files.
#include <numeric>
#include <random>

#include "crash_fixture.h"
#include "service_process.h"

namespace probebake {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// Slope of a straight line through the points, by least squares.
double slope(const std::vector<double>& x, const std::vector<double>& y) {
    const auto n = static_cast<double>(x.size());
    const double mean_x = std::accumulate(x.begin(), x.end(), 0.0) / n;
    const double mean_y = std::accumulate(y.begin(), y.end(), 0.0) / n;
    double xy = 0.0;
    double xx = 0.0;
    for (size_t i = 0; i < x.size(); ++i) {
        xy += (x[i] - mean_x) * (y[i] - mean_y);
        xx += (x[i] - mean_x) * (x[i] - mean_x);
    }
    return xy / xx;
}

/// Submits, waits, downloads, cancels, deletes, as clients do, until told to stop.
uint64_t work(const test::ServiceProcess& service, uint64_t seed, const std::stop_token& stop) {
    std::mt19937_64 random(seed);
    uint64_t jobs = 0;
    while (!stop.stop_requested()) {
        Json request = test::costly_request(1 + static_cast<int>(random() % 4), 8);
        request["quality"]["settings"]["leaf_grid"] = 4;
        request["seed"] = random() % 1000;
        const std::optional<std::string> id = service.submit(request);
        if (!id) {
            std::this_thread::sleep_for(50ms);
            continue;
        }
        ++jobs;
        const std::string bake = "/v1/bakes/" + *id;
        if (random() % 8 == 0) {
            service.client().Post(bake + ":cancel");
            continue;
        }
        service.wait_until_ended(*id);
        switch (random() % 5) {
            case 0:
                service.get(bake + "/archive.tar");
                break;
            case 1:
                service.get(bake + "/events");
                break;
            case 2:
                service.client().Delete(bake);
                break;
            case 3:
                service.get("/metrics");
                service.get("/v1/bakes?page_size=100");
                break;
            default:
                for (const auto& [name, digest] : service.digests(*id)) {
                    service.get(std::string(bake).append("/probes/").append(name));
                }
        }
    }
    return jobs;
}

TEST(Soak, C13_MemoryAndFilesStayAsTheyAre) {
    const int seconds = test::form("PROBEBAKE_SOAK_SECONDS", 6);
    const test::TempFolder folder;
    test::ServiceProcess service(folder.path(), false, {"--keep-jobs", "20"});
    std::atomic<uint64_t> jobs{0};
    std::vector<double> hours;
    std::vector<double> megabytes;
    std::vector<size_t> files;
    {
        std::vector<std::jthread> clients;
        for (uint64_t i = 0; i < 3; ++i) {
            clients.emplace_back(
                [&, i](const std::stop_token& stop) { jobs += work(service, i, stop); });
        }
        const auto begin = Clock::now();
        for (auto now = begin; now < begin + std::chrono::seconds(seconds); now = Clock::now()) {
            std::this_thread::sleep_for(250ms);
            // A third of the time to fill caches and pools.
            if (now < begin + std::chrono::seconds(seconds) / 3) continue;
            hours.push_back(std::chrono::duration<double>(now - begin).count() / 3600.0);
            megabytes.push_back(static_cast<double>(service.resident_bytes()) / 1e6);
            files.push_back(service.open_files());
        }
    }
    ASSERT_TRUE(service.running()) << service.process().err();
    const double growth = slope(hours, megabytes);
    const auto third = static_cast<std::ptrdiff_t>(files.size() / 3);
    const size_t most_early = *std::max_element(files.begin(), files.begin() + third);
    const size_t most_late = *std::max_element(files.end() - third, files.end());
    std::cout << seconds << " s, " << jobs << " jobs: " << growth << " MB/h at " << megabytes.back()
              << " MB, at most " << most_early << " open files in the first third that counts and "
              << most_late << " in the last\n";
    // 32 connections at most, 4 pinned files each: whatever leaks goes beyond that.
    EXPECT_LE(most_late, most_early + 16);
    // A few seconds cannot tell a megabyte per hour: they tell a leak of 50 KB per job, or where a
    // busy machine does few jobs, 10 MB in all, as threads' heaps still fill.
    const bool long_form = seconds >= 600;
    const double short_bound = std::max(10.0, 0.05 * static_cast<double>(jobs)) * 3600.0 / seconds;
    if (!test::sanitized()) {
        EXPECT_LT(growth, long_form ? 1.0 : short_bound);
    }
}

}  // namespace
}  // namespace probebake
