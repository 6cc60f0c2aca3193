// A job: one accepted request and what is told about it; its states are store/job_state.h's.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bake/job_spec.h"
#include "engine/bake_run.h"
#include "io/spec_error.h"
#include "scene/scene_library.h"
#include "store/tables.h"

namespace probebake {

/// RFC 3339 in UTC with milliseconds: 2026-03-01T12:00:00.000Z.
std::string rfc3339(UnixMs time);

/// Who jobs belong to where nobody has to say who they are.
inline constexpr const char* kNoTenant = "local";

/// What a job is made of: a checked request and the scene file that it named when it was accepted.
struct JobRequest {
    JobSpec spec;
    SceneFile scene;
    std::string tenant = kNoTenant;
    /// The client's name for this request, and the digest of what it sent: the same key and digest
    /// again are the same job.
    std::optional<std::string> idempotency_key = {};
    std::string sha256 = {};
};

/// Digest of everything that a job takes from files: the scene's and the pictures of its skies.
/// Throws IoError where the scene's cannot be read; a picture that cannot is another one.
std::string pinned_sha256(const SceneFile& scene, const JobSpec& spec);

/// Why a job failed, in words fit for its client.
struct JobFailure {
    /// "scene", "scene_changed", "units", "poison", "budget", "storage", "memory" or "internal".
    std::string code;
    std::string detail;
    std::vector<SpecIssue> issues;
};

Json write_failure(const JobFailure& failure);
/// Of what write_failure wrote.
JobFailure read_failure(const Json& json);

/// A job at one moment.
struct JobSnapshot {
    std::string id;
    std::string tenant;
    int64_t sequence = 0;  // grows with every job that is accepted
    uint64_t version = 0;  // grows with every change that clients can see
    JobState state = JobState::kQueued;
    std::string scene;
    UnixMs created = 0;
    std::optional<UnixMs> started;
    std::optional<UnixMs> ended;
    BakeProgress progress;
    std::optional<JobFailure> failure;
    std::vector<std::string> warnings;
};

}  // namespace probebake
