#include "jobs/job.h"

#include <gtest/gtest.h>

#include <set>

namespace probebake {
namespace {

TEST(Job, IdsHaveTheirFormAndAreNew) {
    std::set<std::string> ids;
    std::set<char> digits;
    for (int i = 0; i < 1000; ++i) {
        const std::string id = new_job_id();
        EXPECT_TRUE(is_job_id(id)) << id;
        EXPECT_EQ(id.size(), 34U);
        ids.insert(id);
        digits.insert(id.begin() + 2, id.end());
    }
    EXPECT_EQ(ids.size(), 1000U);
    EXPECT_EQ(digits.size(), 16U);
}

TEST(Job, OtherTextsAreNoIds) {
    const std::string id = new_job_id();
    for (const std::string& text :
         {std::string(), std::string("b-"), id + "0", id.substr(0, 33), "c" + id.substr(1),
          "b-" + std::string(32, 'G'), "b-" + std::string(32, 'A'), "../" + id.substr(3)}) {
        EXPECT_FALSE(is_job_id(text)) << text;
    }
}

TEST(Job, TimesAreRfc3339InUtc) {
    const auto time = UnixMs{951'782'400'007};
    EXPECT_EQ(rfc3339(time), "2000-02-29T00:00:00.007Z");
}

TEST(Job, StatesHaveNames) {
    for (const JobState state : {JobState::kQueued, JobState::kRunning, JobState::kCancelling,
                                 JobState::kSucceeded, JobState::kFailed, JobState::kCancelled}) {
        EXPECT_EQ(job_state_of(name_of(state)), state);
    }
    EXPECT_EQ(job_state_of("queued"), std::nullopt);
    EXPECT_FALSE(is_terminal(JobState::kQueued) || is_terminal(JobState::kRunning) ||
                 is_terminal(JobState::kCancelling));
    EXPECT_TRUE(is_terminal(JobState::kSucceeded) && is_terminal(JobState::kFailed) &&
                is_terminal(JobState::kCancelled));
}

}  // namespace
}  // namespace probebake
