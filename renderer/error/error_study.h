// The error tables side by side: what `probebake study error-table` prints.
//
// Columns: ray_cast (512 × 512 frame), sh9 (thesis_error_table, fitted to the ray-cast table of the
// 256 directions), exact (projected areas), octant_table.
#pragma once

#include <array>
#include <iosfwd>
#include <vector>

#include "error/error_table.h"

namespace probebake {

std::vector<uint8_t> all_masks();

/// Which rows to write: every mask with every direction, by default the whole table.
struct ErrorRows {
    std::vector<uint8_t> masks = all_masks();
    std::vector<Vec3> directions = even_directions();
};

/// Writes a header line and the rows `mask,dx,dy,dz,ray_cast,sh9,exact,octant_table`, mask by mask;
/// numbers with the fewest digits that read back as the same double. Throws std::invalid_argument,
/// before anything is written, for a direction that is not finite and of unit length
/// (kUnitTolerance: six decimals are enough). Does not check the stream.
void write_error_csv(std::ostream& out, const ErrorRows& rows = {});

/// How far a table is from the exact one, over directions and masks.
struct Deviation {
    double mean = 0.0;  // signed: table − exact
    double rms = 0.0;
    double max = 0.0;  // of the absolute value
};
Deviation deviation(const ErrorTable& table, const ErrorTable& exact);

struct ErrorAccuracy {
    struct FrameBuffer {
        int frame_px = 0;
        double thesis_bound = 0.0;  // table 3.1: of the area, which is 1 to 1.73 for the parent
        Deviation ray_cast;         // over the 256 directions
    };
    std::array<FrameBuffer, 4> frame_buffers;  // 64, 128, 256, 512
    Deviation sh9;                             // over the 256 directions, those of the fit
    Deviation sh9_between;                     // over 4,096 others
    double sh9_lowest = 0.0;                   // smallest value over all of them: the undershoot
    Deviation octant_table;                    // over the 256 directions
    Deviation octant_table_between;            // over 4,096 others
};

/// The thesis's table 3.1 with the true errors of its frame buffers, and those of the two codes.
ErrorAccuracy measure_error_accuracy();
void print_error_accuracy(std::ostream& out, const ErrorAccuracy& accuracy);

}  // namespace probebake
