// A job: one accepted request, its states and what is told about it.
//
//   QUEUED ─► RUNNING ─► SUCCEEDED | FAILED
//     │          └─► CANCELLING ─► CANCELLED (or SUCCEEDED, FAILED: it ended before it noticed)
//     └─► CANCELLED
//
// SUCCEEDED, FAILED and CANCELLED are terminal: a job in one of them never changes again.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bake/job_spec.h"
#include "engine/bake_run.h"
#include "io/spec_error.h"
#include "scene/scene_library.h"

namespace probebake {

enum class JobState { kQueued, kRunning, kCancelling, kSucceeded, kFailed, kCancelled };

std::string_view name_of(JobState state);
std::optional<JobState> job_state_of(std::string_view name);
constexpr bool is_terminal(JobState state) { return state >= JobState::kSucceeded; }

/// "b-" and 128 random bits of the kernel as 32 hexadecimal digits: who was not told it cannot
/// guess it.
std::string new_job_id();
bool is_job_id(std::string_view text);

using WallTime = std::chrono::system_clock::time_point;

/// RFC 3339 in UTC with milliseconds: 2026-03-01T12:00:00.000Z.
std::string rfc3339(WallTime time);

/// What a job is made of: a checked request and the scene file that it named when it was accepted.
struct JobRequest {
    JobSpec spec;
    SceneFile scene;
};

/// Why a job failed, in words fit for its client.
struct JobFailure {
    std::string code;  // "scene", "storage", "memory" or "internal"
    std::string detail;
    std::vector<SpecIssue> issues;
};

/// A job at one moment.
struct JobSnapshot {
    std::string id;
    uint64_t sequence = 0;  // grows with every job that is accepted
    JobState state = JobState::kQueued;
    std::string scene;
    WallTime created;
    std::optional<WallTime> started;
    std::optional<WallTime> ended;
    BakeProgress progress;
    std::optional<JobFailure> failure;
    std::vector<std::string> warnings;
};

}  // namespace probebake
