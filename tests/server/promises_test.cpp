// Random submissions, cancellations, deletions and restarts against a model of what was promised.
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "jobs/job_manager.h"
#include "net_jobs.h"

namespace probebake {
namespace {

using namespace std::chrono_literals;

class PromisesTest : public testing::TestWithParam<uint64_t> {
  protected:
    PromisesTest() {
        test::write_scenes(folder_.path() / "scenes");
        file_ = *SceneLibrary(folder_.path() / "scenes").find("net");
        pool_.run([&] { scene_ = std::make_shared<const Scene>(load_scene(file_)); });
        start();
    }
    void start() {
        store_.emplace(folder_.path() / "data", JobStore::Options{});
        jobs_.emplace(
            pool_, *store_,
            SceneSource{.find = [this](const std::string&) { return file_; },
                        .load = [this](const SceneFile&, const CancelToken&) { return scene_; }},
            JobManager::Options{
                .max_running = 3, .max_queued = 1000, .max_per_tenant = 1000, .keep_jobs = 1000});
    }
    void restart() {
        jobs_.reset();
        store_.reset();
        start();
    }

    /// What is known of a job.
    struct Known {
        std::string key;
        uint64_t units = 0;
        bool cancelled = false;
        bool removed = false;
        std::optional<JobState> end;
    };

    void submit() {
        const int probes = 1 + static_cast<int>(random_() % 4);
        Json request = test::costly_request(probes, 6);
        request["quality"]["settings"]["leaf_grid"] = 4;
        JobRequest job{.spec = read_job(request), .scene = file_};
        job.idempotency_key = "k" + std::to_string(random_() % 40);
        job.sha256 = std::to_string(probes);
        try {
            const JobManager::Submitted taken = jobs_->submit(job);
            EXPECT_EQ(taken.replayed, known_.count(taken.job.id) == 1);
            if (taken.replayed) {
                EXPECT_EQ(known_[taken.job.id].key, *job.idempotency_key);
                EXPECT_EQ(known_[taken.job.id].units, static_cast<uint64_t>(probes));
            }
            known_[taken.job.id].key = *job.idempotency_key;
            known_[taken.job.id].units = static_cast<uint64_t>(probes);
        } catch (const KeyReused&) {
            bool used = false;
            for (const auto& [id, known] : known_) {
                used = used || (known.key == *job.idempotency_key && !known.removed &&
                                known.units != static_cast<uint64_t>(probes));
            }
            EXPECT_TRUE(used) << "a fresh key was refused";
        }
    }
    void cancel(const std::string& id, Known& known) {
        const std::optional<JobSnapshot> job = jobs_->cancel(id);
        EXPECT_EQ(job.has_value(), !known.removed);
        if (job && !is_terminal(job->state)) known.cancelled = true;
        if (job && job->state == JobState::kCancelled) known.cancelled = true;
    }
    void remove(const std::string& id, Known& known) {
        const std::optional<JobSnapshot> before = jobs_->find(id);
        const bool removed = jobs_->remove(id);
        if (before && is_terminal(before->state)) {
            EXPECT_TRUE(removed);
        }
        if (known.removed) {
            EXPECT_FALSE(removed);
        }
        known.removed = known.removed || removed;
    }
    void look() {
        for (auto& [id, known] : known_) {
            const std::optional<JobSnapshot> job = jobs_->find(id);
            ASSERT_EQ(job.has_value(), !known.removed) << id;
            if (!job) continue;
            if (known.end) {
                ASSERT_EQ(job->state, *known.end) << "a terminal state changed";
            }
            if (is_terminal(job->state)) known.end = job->state;
            ASSERT_NE(job->state, JobState::kFailed) << job->failure->detail;
        }
    }

    test::TempFolder folder_;
    RenderPool pool_{2};
    SceneFile file_;
    std::shared_ptr<const Scene> scene_;
    std::optional<JobStore> store_;
    std::optional<JobManager> jobs_;
    std::map<std::string, Known> known_;
    std::mt19937_64 random_{GetParam()};
};

TEST_P(PromisesTest, AreKept) {
    for (int i = 0; i < 120; ++i) {
        const uint64_t what = random_() % 20;
        if (what < 8 || known_.empty()) {
            submit();
        } else {
            auto at = known_.begin();
            std::advance(at, random_() % known_.size());
            if (what < 11) cancel(at->first, at->second);
            if (what >= 11 && what < 14) remove(at->first, at->second);
            if (what == 14) restart();
            if (what > 17) std::this_thread::sleep_for(20ms);
        }
        look();
        if (HasFatalFailure()) return;
    }
    restart();
    for (auto& [id, known] : known_) {
        if (known.removed) continue;
        for (int i = 0; i < 60000 && !is_terminal(jobs_->find(id)->state); ++i) {
            std::this_thread::sleep_for(5ms);
        }
        const JobSnapshot job = *jobs_->find(id);
        if (known.end) {
            EXPECT_EQ(job.state, *known.end);
        }
        if (!known.cancelled) {
            EXPECT_EQ(job.state, JobState::kSucceeded);
            const auto units = store_->published(job.sequence, 0, 100);
            EXPECT_EQ(units.size(), known.units) << "every probe, and none of them twice";
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, PromisesTest, testing::Range<uint64_t>(1, 5));

}  // namespace
}  // namespace probebake
