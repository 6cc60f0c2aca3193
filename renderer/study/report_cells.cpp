#include "study/report_cells.h"

#include <stdexcept>

namespace probebake::study {

const Json& renderer_row(const Json& renderers, const std::string& renderer) {
    for (const Json& row : renderers) {
        if (row.at("renderer") == renderer) return row;
    }
    throw std::invalid_argument("a result without " + renderer);
}

std::vector<std::string> class_and_error_cells(const Json& row) {
    std::vector<std::string> cells;
    for (const Json& count : row.at("classes")) {
        const double share = count.get<double>() / row.at("pixels").get<double>();
        cells.push_back(decimals(100.0 * share, 1) + " %");
    }
    for (const char* against : {"reference", "truth"}) {
        const Json& error = row.at(against);
        cells.push_back(decimals(number_or_none(error.at("psnr_db")), 2));
        cells.push_back(decimals(number_or_none(error.at("ssim")), 4));
        cells.push_back(decimals(error.at("rmse").get<double>(), 5));
    }
    return cells;
}

const ThesisArea* thesis_area(const std::string& scene) {
    for (const ThesisArea& area : thesis_areas()) {
        if (scene == area.name) return &area;
    }
    return nullptr;
}

double ratio(uint64_t a, uint64_t b) { return static_cast<double>(a) / static_cast<double>(b); }

std::optional<double> number_or_none(const Json& value) {
    return value.is_null() ? std::nullopt : std::optional<double>(value.get<double>());
}

std::string text_of(double x) {
    std::string text = decimals(x, 3);
    while (text.back() == '0') text.pop_back();
    if (text.back() == '.') text.pop_back();
    return text;
}

std::string beside(const std::string& ours, bool with_thesis, std::optional<double> thesis,
                   int count) {
    return with_thesis && thesis ? ours + " (" + decimals(*thesis, count) + ")" : ours;
}

std::string titled(const std::string& title, bool with_thesis, const std::string& thesis) {
    return with_thesis ? title + "; in brackets the thesis's " + thesis : title;
}

}  // namespace probebake::study
