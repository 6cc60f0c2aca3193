// What the workload (workload.cpp) was promised, and whether a store keeps it.
//
//   "insert ID"  "unit ID UNIT DIGEST"  "end ID STATE"  "cancel ID"  "delete ID"
#pragma once

#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "store/job_store.h"

namespace probebake::test {

struct Promises {
    struct Job {
        std::map<int64_t, std::string> units;  // digests
        std::optional<JobState> end;
        bool cancel = false;
        bool removal_begun = false;
        bool removed = false;
    };
    std::map<std::string, Job> jobs;

    void add(const std::string& line) {
        std::istringstream words(line);
        std::string what;
        std::string id;
        words >> what >> id;
        if (what == "insert") jobs[id];
        if (what == "unit") {
            int64_t unit = 0;
            std::string digest;
            words >> unit >> digest;
            jobs[id].units[unit] = digest;
        }
        if (what == "end") {
            int state = 0;
            words >> state;
            jobs[id].end = static_cast<JobState>(state);
        }
        if (what == "cancel") jobs[id].cancel = true;
        // Said before it is asked for: from then on the job may be gone or not.
        if (what == "deleting") jobs[id].removal_begun = true;
        if (what == "delete") jobs[id].removed = true;
    }

    /// What is broken of them, one line each.
    std::vector<std::string> broken_by(JobStore& store) const {
        std::vector<std::string> broken;
        std::map<std::string, StoredJob> stored;
        for (const StoredJob& job : store.jobs()) stored[job.id] = job;
        for (const auto& [id, job] : jobs) {
            const auto at = stored.find(id);
            if (at == stored.end()) {
                if (!job.removal_begun) broken.push_back("lost job " + id);
                continue;
            }
            if (job.removed) broken.push_back("a deleted job is back: " + id);
            if (job.end && at->second.state != *job.end) broken.push_back("another end: " + id);
            if (job.cancel && !is_terminal(at->second.state)) {
                broken.push_back("not cancelled: " + id);
            }
            for (const auto& [unit, digest] : job.units) {
                const auto file = store.open_unit_file(
                    at->second.sequence, "p" + std::to_string(unit), "albedo", "cube.exr");
                if (!file || file->file.sha256 != digest) broken.push_back("lost unit of " + id);
            }
        }
        // Every row names a whole file, promised or not.
        for (const auto& [id, job] : stored) {
            for (const StoredUnit& unit : store.published(job.sequence, 0, 100000)) {
                const auto file = store.open_unit_file(job.sequence, unit.name.probe,
                                                       unit.name.state, "cube.exr");
                if (!file || !file->content) broken.push_back("a row without its file: " + id);
            }
        }
        return broken;
    }
};

}  // namespace probebake::test
