// A table of texts, as Markdown and as CSV.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace probebake::study {

struct TextTable {
    std::string name;   // of its CSV file
    std::string title;  // above it in the report
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows;

    std::string markdown() const;
    /// Quoted where a cell holds a comma or a quote.
    std::string csv() const;
};

/// Writes OUT/tables/NAME.csv and returns the Markdown; the folder is there. Throws IoError.
std::string save_table(const TextTable& table, const std::filesystem::path& out);

std::string decimals(double x, int count);
/// A dash where there is none.
std::string decimals(const std::optional<double>& x, int count);
/// 12345 as "12,345".
std::string grouped_digits(uint64_t x);

}  // namespace probebake::study
