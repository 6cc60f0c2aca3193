// workload DATA ACK JOBS: uses a store as the service does, and writes every promise into the file
// ACK once it was made. Exit code 3: the store refused something with an error.
#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>

#include "io/sha256.h"
#include "store/job_store.h"

namespace probebake {
namespace {

class Workload {
  public:
    Workload(const char* data, const char* ack)
        : ack_(::open(ack, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644)), store_(data, {}) {}

    void run(int jobs) {
        for (int i = 0; i < jobs; ++i) {
            const std::string id = new_job_id();
            const int64_t job = insert(id);
            // Requests of all sizes: the log of the database is checkpointed on the way.
            if (i % 7 == 3) {
                store_.end(job, {.state = JobState::kCancelled, .ended = 1}, {}, never);
                promise("end " + id + " 5");
                continue;
            }
            store_.start(job, 1);
            const int units = 1 + i % 3;
            for (int unit = 0; unit < units; ++unit) bake(id, job, unit);
            if (i % 5 == 4) {
                store_.request_cancel(job);
                promise("cancel " + id);
            }
            if (i % 4 == 1) continue;  // still runs
            finish(id, job);
            if (i % 6 == 2) {
                promise("deleting " + id);
                store_.remove(job);
                promise("delete " + id);
                store_.tidy();
            }
        }
    }

  private:
    static bool never() { return true; }  // of waiting for room

    void promise(const std::string& what) const {
        const std::string line = what + "\n";
        if (::write(ack_.get(), line.data(), line.size()) < 0) std::abort();
    }
    int64_t insert(const std::string& id) {
        const std::string request((counter_++ % 16) * 3000, 'r');
        const int64_t job = store_
                                .insert({.id = id,
                                         .tenant = "local",
                                         .scene = "net",
                                         .scene_sha256 = "s",
                                         .request = request,
                                         .request_sha256 = "r",
                                         .idempotency_key = {},
                                         .units = 3,
                                         .created = 1})
                                .sequence;
        promise("insert " + id);
        return job;
    }
    void bake(const std::string& id, int64_t job, int unit) {
        const std::string text(1000 + 997 * (counter_++ % 9), static_cast<char>('a' + unit));
        const std::string content = text + id;
        const std::string digest = sha256_hex(std::as_bytes(std::span(content)));
        const int64_t attempt =
            store_.begin_unit(job, {unit, "p" + std::to_string(unit), "albedo"});
        store_.publish(job, unit, attempt, "record",
                       {{"cube.exr", std::as_bytes(std::span(content)), digest}});
        promise("unit " + id + " " + std::to_string(unit) + " " + digest);
    }
    void finish(const std::string& id, int64_t job) {
        const std::string report = "report of " + id;
        TemporaryFile file(store_.data());
        file.write(std::as_bytes(std::span(report)));
        file.sync();
        const std::string digest = sha256_hex(std::as_bytes(std::span(report)));
        if (!store_.end(job, {.state = JobState::kSucceeded, .ended = 1},
                        {{"report.json", file.path(), report.size(), digest}}, never)) {
            throw IoError("workload", "a job could not be ended");
        }
        promise("end " + id + " 3");
    }

    Descriptor ack_;
    JobStore store_;
    uint64_t counter_ = 0;
};

}  // namespace
}  // namespace probebake

int main(int argc, char** argv) {
    if (argc != 4) return 2;
    try {
        probebake::Workload(argv[1], argv[2]).run(std::atoi(argv[3]));
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 3;
    }
    return 0;
}
