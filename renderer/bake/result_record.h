// A ProbeResult as bytes, so that a bake that was interrupted goes on where it was: the report
// needs what every probe found, and a grid's atlases its tile, not only its files.
//
// Numbers bit by bit, so that the report of an interrupted bake is that of an uninterrupted one.
// The record begins with a version; probe and lighting state are those of the work unit it belongs
// to and are not in it, nor are the bytes of the files.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "bake/probe_result.h"

namespace probebake {

std::string write_result_record(const ProbeResult& result);

/// No value for a record of another version, or one that is damaged: the unit is baked anew.
/// `unit` counts probes × states, states fastest.
std::optional<ProbeResult> read_result_record(std::string_view record, const JobSpec& job,
                                              size_t unit);

}  // namespace probebake
