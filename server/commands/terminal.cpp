#include "commands/terminal.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>

namespace probebake {

ProgressBar::ProgressBar(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() { end_line(); }

void ProgressBar::end_line() {
    if (line_open_) std::cerr << '\n';
    line_open_ = false;
}

void ProgressBar::show(const std::string& phase, uint64_t done, uint64_t total,
                       std::optional<double> seconds_left) {
    if (quiet_) return;
    const uint64_t tenth = total > 0 ? 10 * done / total : 0;
    const bool new_phase = phase != phase_;
    const auto now = std::chrono::steady_clock::now();
    const bool due = terminal_ ? now - shown_at_ > std::chrono::milliseconds(100) || done == total
                               : tenth != shown_tenth_;
    if (!new_phase && !due) return;
    if (new_phase) end_line();
    phase_ = phase;
    shown_tenth_ = tenth;
    shown_at_ = now;

    std::string line = phase;
    if (total > 0) {
        if (terminal_) {
            constexpr uint64_t kWidth = 30;
            const uint64_t filled = kWidth * done / total;
            line += " [" + std::string(filled, '=') + std::string(kWidth - filled, ' ') + "]";
        }
        line += " " + std::to_string(done) + "/" + std::to_string(total);
        if (seconds_left) line += ", " + fixed(*seconds_left, 1) + " s left";
    }
    if (terminal_) {
        std::cerr << "\r\033[K" << line << std::flush;
        line_open_ = true;
    } else {
        std::cerr << line << '\n';
    }
}

Table::Table(std::vector<std::string> header) { rows_.push_back(std::move(header)); }

void Table::add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }

std::string Table::text() const {
    std::vector<size_t> widths(rows_.front().size());
    for (const auto& row : rows_) {
        for (size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
    }
    std::string text;
    for (const auto& row : rows_) {
        std::string line;
        for (size_t c = 0; c < row.size(); ++c) {
            const std::string space(widths[c] - row[c].size(), ' ');
            // The first column holds names, the others numbers.
            line += c == 0 ? row[c] + space : "  " + space + row[c];
        }
        text += line + "\n";
    }
    return text;
}

std::string fixed(double x, int decimals) {
    std::array<char, 64> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.*f", decimals, x);
    return buffer.data();
}

std::string grouped(uint64_t x) {
    std::string digits = std::to_string(x);
    for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3) {
        digits.insert(static_cast<size_t>(at), ",");
    }
    return digits;
}

std::string bytes_text(uint64_t bytes) {
    constexpr std::array<const char*, 5> kUnits = {"B", "KiB", "MiB", "GiB", "TiB"};
    auto value = static_cast<double>(bytes);
    size_t unit = 0;
    while (value >= 1024.0 && unit + 1 < kUnits.size()) {
        value /= 1024.0;
        ++unit;
    }
    return fixed(value, unit == 0 ? 0 : 1) + " " + kUnits[unit];
}

}  // namespace probebake
