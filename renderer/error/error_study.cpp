#include "error/error_study.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iomanip>
#include <locale>
#include <numeric>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "error/octant_error.h"
#include "error/projected_area_error.h"
#include "error/ray_cast_error.h"
#include "error/sh_error.h"

namespace probebake {
namespace {

constexpr int kDirectionsBetween = 4096;

/// ", x" with the fewest digits that identify x, whatever the locale.
void append(std::string& line, double x) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr;
    line.append(",").append(digits.data(), end);
}

/// The values of a code at the directions of another table.
template <class Code>
ErrorTable evaluate(const Code& code, const std::vector<Vec3>& directions) {
    ErrorTable table{directions, std::vector<MaskErrors>(directions.size())};
    for (size_t n = 0; n < directions.size(); ++n) {
        for (size_t mask = 0; mask < kMaskCount; ++mask) {
            table.errors[n][mask] = code.error(directions[n], static_cast<uint8_t>(mask));
        }
    }
    return table;
}

double lowest(const ErrorTable& table) {
    double least = 1.0;
    for (const MaskErrors& errors : table.errors) {
        least = std::min(least, *std::min_element(errors.begin(), errors.end()));
    }
    return least;
}

/// Table 3.1: half a cell of the frame beside every edge of eight children, 48 units of length.
double thesis_bound(int frame_px) {
    const double half_cell = 1.0 / frame_px;
    return 48.0 * half_cell;
}

}  // namespace

std::vector<uint8_t> all_masks() {
    std::vector<uint8_t> masks(kMaskCount);
    std::iota(masks.begin(), masks.end(), uint8_t{0});
    return masks;
}

void write_error_csv(std::ostream& out, const ErrorRows& rows) {
    const ErrorTable ray_cast = ray_cast_errors(rows.directions);
    const ErrorTable exact = projected_area_errors(rows.directions);
    const ShErrorTable& sh9 = thesis_error_table();
    const OctantErrorTable octant_table;
    out << "mask,dx,dy,dz,ray_cast,sh9,exact,octant_table\n";
    for (const uint8_t mask : rows.masks) {
        for (size_t n = 0; n < rows.directions.size(); ++n) {
            const Vec3& d = rows.directions[n];
            std::string line = std::to_string(mask);
            for (const double x : {d.x, d.y, d.z, ray_cast.errors[n][mask], sh9.error(d, mask),
                                   exact.errors[n][mask], octant_table.error(d, mask)}) {
                append(line, x);
            }
            out << line << '\n';
        }
    }
}

Deviation deviation(const ErrorTable& table, const ErrorTable& exact) {
    if (table.errors.size() != exact.errors.size() || table.errors.empty()) {
        throw std::invalid_argument("deviation: expected two tables of the same directions");
    }
    Deviation result;
    double squares = 0.0;
    for (size_t n = 0; n < table.errors.size(); ++n) {
        for (size_t mask = 0; mask < kMaskCount; ++mask) {
            const double difference = table.errors[n][mask] - exact.errors[n][mask];
            result.mean += difference;
            squares += difference * difference;
            result.max = std::max(result.max, std::abs(difference));
        }
    }
    const auto count = static_cast<double>(table.errors.size() * kMaskCount);
    result.mean /= count;
    result.rms = std::sqrt(squares / count);
    return result;
}

ErrorAccuracy measure_error_accuracy() {
    const ErrorTable exact = projected_area_errors(even_directions());
    const ErrorTable exact_between = projected_area_errors(even_directions(kDirectionsBetween));

    ErrorAccuracy accuracy;
    int frame_px = 64;
    for (ErrorAccuracy::FrameBuffer& row : accuracy.frame_buffers) {
        row = {frame_px, thesis_bound(frame_px),
               deviation(ray_cast_errors(exact.directions, frame_px), exact)};
        frame_px *= 2;
    }

    const ErrorTable sh9 = evaluate(thesis_error_table(), exact.directions);
    const ErrorTable sh9_between = evaluate(thesis_error_table(), exact_between.directions);
    accuracy.sh9 = deviation(sh9, exact);
    accuracy.sh9_between = deviation(sh9_between, exact_between);
    accuracy.sh9_lowest = std::min(lowest(sh9), lowest(sh9_between));

    const OctantErrorTable octant_table;
    accuracy.octant_table = deviation(evaluate(octant_table, exact.directions), exact);
    accuracy.octant_table_between =
        deviation(evaluate(octant_table, exact_between.directions), exact_between);
    return accuracy;
}

void print_error_accuracy(std::ostream& out, const ErrorAccuracy& accuracy) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    const auto row = [&text](const std::string& name, const Deviation& d) -> std::ostream& {
        return text << std::left << std::setw(28) << name << std::right << std::fixed
                    << std::setprecision(6) << std::setw(10) << d.rms << std::setw(10) << d.max
                    << std::showpos << std::setw(11) << d.mean << std::noshowpos;
    };
    text << "difference from exact              rms       max       mean  thesis bound\n";
    for (const ErrorAccuracy::FrameBuffer& frame : accuracy.frame_buffers) {
        row("ray_cast, frame " + std::to_string(frame.frame_px), frame.ray_cast)
            << std::defaultfloat << std::setw(14) << frame.thesis_bound << '\n';
    }
    row("sh9", accuracy.sh9) << '\n';
    row("sh9, other directions", accuracy.sh9_between) << '\n';
    row("octant_table", accuracy.octant_table) << '\n';
    row("octant_table, other dir.", accuracy.octant_table_between) << '\n';
    text << "smallest value of sh9: " << accuracy.sh9_lowest << '\n';
    out << text.str();
}

}  // namespace probebake
