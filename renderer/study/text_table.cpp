#include "study/text_table.h"

#include <cmath>
#include <cstdio>

#include "io/file.h"

namespace probebake::study {
namespace {

std::string csv_cell(const std::string& cell) {
    if (cell.find_first_of(",\"\n") == std::string::npos) return cell;
    std::string quoted = "\"";
    for (const char c : cell) quoted += c == '"' ? "\"\"" : std::string(1, c);
    return quoted + "\"";
}

}  // namespace

std::string TextTable::markdown() const {
    std::string text = "**" + title + "**\n\n|";
    for (const std::string& column : columns) text += " " + column + " |";
    text += "\n|";
    for (size_t i = 0; i < columns.size(); ++i) text += "---|";
    for (const auto& row : rows) {
        text += "\n|";
        for (const std::string& cell : row) text += " " + cell + " |";
    }
    return text + "\n\n";
}

std::string save_table(const TextTable& table, const std::filesystem::path& out) {
    write_file_atomically(out / "tables" / (table.name + ".csv"), table.csv());
    return table.markdown();
}

std::string TextTable::csv() const {
    const auto line = [](const std::vector<std::string>& cells) {
        std::string text;
        for (size_t i = 0; i < cells.size(); ++i) text += (i > 0 ? "," : "") + csv_cell(cells[i]);
        return text + "\n";
    };
    std::string text = line(columns);
    for (const auto& row : rows) text += line(row);
    return text;
}

std::string decimals(double x, int count) {
    if (std::isinf(x)) return "∞";  // over an image without error
    char text[64];
    std::snprintf(text, sizeof(text), "%.*f", count, x);
    return text;
}

std::string decimals(const std::optional<double>& x, int count) {
    return x ? decimals(*x, count) : "–";
}

std::string grouped_digits(uint64_t x) {
    std::string digits = std::to_string(x);
    for (size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
    return digits;
}

}  // namespace probebake::study
