// The states of a job, as clients see them and the database keeps them.
//
//   QUEUED ─► RUNNING ─► SUCCEEDED | FAILED
//     │  ▲       │ └─► CANCELLING ─► CANCELLED (or SUCCEEDED, FAILED: it ended before it noticed)
//     │  └───────┘ the service ended: it goes on at the next start
//     └─► CANCELLED
//
// SUCCEEDED, FAILED and CANCELLED are terminal: a job in one of them never changes again.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace probebake {

/// The numbers are in databases: they keep their meaning.
enum class JobState { kQueued, kRunning, kCancelling, kSucceeded, kFailed, kCancelled };

std::string_view name_of(JobState state);
std::optional<JobState> job_state_of(std::string_view name);
constexpr bool is_terminal(JobState state) { return state >= JobState::kSucceeded; }

/// "b-" and 128 random bits of the kernel as 32 hexadecimal digits: who was not told it cannot
/// guess it.
std::string new_job_id();
bool is_job_id(std::string_view text);

}  // namespace probebake
