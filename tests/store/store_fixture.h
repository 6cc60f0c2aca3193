// A store in a folder of its own that can be closed and opened again, and jobs for it.
#pragma once

#include <gtest/gtest.h>

#include "io/sha256.h"
#include "store/job_store.h"
#include "support/temp_folder.h"

namespace probebake::test {

inline std::string digest_of(const std::string& text) {
    return sha256_hex(std::as_bytes(std::span(text)));
}

inline NewFile new_file(const std::string& name, const std::string& text) {
    return {name, std::as_bytes(std::span(text)), digest_of(text)};
}

inline std::string text_of(const OpenFile& file) {
    std::string text(file.size_bytes(), '\0');
    EXPECT_EQ(file.read_at(0, text), text.size());
    return text;
}

class StoreTest : public testing::Test {
  protected:
    StoreTest() { open(); }
    void open() { store_.emplace(data(), JobStore::Options{}); }
    void reopen() {
        store_.reset();
        open();
    }
    std::filesystem::path data() const { return folder_.path() / "data"; }
    std::filesystem::path path_of(const std::string& text) const {
        const std::string digest = digest_of(text);
        return data() / "files" / digest.substr(0, 2) / digest;
    }

    static NewJob new_job() {
        return {.id = new_job_id(),
                .tenant = "local",
                .scene = "net",
                .scene_sha256 = digest_of("net"),
                .request = "{}",
                .request_sha256 = digest_of("{}"),
                .idempotency_key = {},
                .units = 3,
                .most_bytes = 50'000,
                .created = 1};
    }
    int64_t insert() { return store_->insert(new_job()).sequence; }
    int64_t running() {
        const int64_t job = insert();
        EXPECT_TRUE(store_->start(job, 2));
        return job;
    }
    static UnitName unit(int64_t number) {
        return {number, "p" + std::to_string(number), "albedo"};
    }
    void publish(int64_t job, int64_t number, const std::string& text) {
        const int64_t attempt = store_->begin_unit(job, unit(number));
        store_->publish(job, number, attempt, "record", {new_file("cube.exr", text)});
    }
    bool end(int64_t job, JobState state = JobState::kSucceeded) {
        return store_->end(job, {.state = state, .ended = 3}, {}, [] { return true; });
    }
    StoredJob find(int64_t job) {
        for (const StoredJob& stored : store_->jobs()) {
            if (stored.sequence == job) return stored;
        }
        return {};
    }
    JobState state(int64_t job) { return find(job).state; }

    TempFolder folder_;
    std::optional<JobStore> store_;
};

}  // namespace probebake::test
