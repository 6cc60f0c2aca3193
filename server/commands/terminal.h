// Progress and tables for people: a bar that redraws itself on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace probebake {

class ProgressBar {
  public:
    /// Silent where `quiet` (machine-readable output).
    explicit ProgressBar(bool quiet);
    ~ProgressBar();

    /// On a terminal at most ten times a second, elsewhere every ten per cent.
    void show(const std::string& phase, uint64_t done, uint64_t total,
              std::optional<double> seconds_left);

  private:
    void end_line();

    bool quiet_;
    bool terminal_;
    bool line_open_ = false;
    std::string phase_;
    uint64_t shown_tenth_ = 0;
    std::chrono::steady_clock::time_point shown_at_{};
};

/// Columns as wide as their widest cell; numbers are right-aligned by whoever formats them.
class Table {
  public:
    explicit Table(std::vector<std::string> header);
    void add(std::vector<std::string> row);
    std::string text() const;

  private:
    std::vector<std::vector<std::string>> rows_;
};

/// A number with a fixed count of decimals.
std::string fixed(double x, int decimals);
/// 12345678 as "12,345,678".
std::string grouped(uint64_t x);
/// A count of bytes with a binary unit.
std::string bytes_text(uint64_t bytes);

}  // namespace probebake
