#include "volume_study/stability.h"

#include <cmath>
#include <sstream>

#include "io/file.h"

namespace probebake::volume_study {
namespace {

constexpr double kMostZ = 4.5;

}  // namespace

std::string short_text(double x) {
    std::ostringstream text;
    text.precision(4);
    text << x;
    return text.str();
}

StabilityCase unbiased(std::string name, std::string checked, const Moments& moments,
                       double exact) {
    const double n = static_cast<double>(moments.count());
    const double error = moments.mean() - exact;
    const double sigma = std::sqrt(moments.variance() / n);
    StabilityCase out{.name = std::move(name),
                      .checked = std::move(checked),
                      .value = short_text(moments.mean()),
                      .bound = short_text(exact) + ", z within ±4.5",
                      .variance = moments.variance()};
    // Weights that never vary carry the rounding of the exact answer alone.
    if (sigma > 1e-9 * std::abs(exact)) {
        out.z = error / sigma;
        out.pass = std::abs(*out.z) < kMostZ;
    } else {
        out.pass = std::abs(error) <= 1e-6 * std::abs(exact);
    }
    return out;
}

StabilityCase at_most(std::string name, std::string checked, double value, double bound) {
    return {.name = std::move(name),
            .checked = std::move(checked),
            .value = short_text(value),
            .bound = "≤ " + short_text(bound),
            .pass = value <= bound};
}

StabilityCase at_least(std::string name, std::string checked, double value, double bound) {
    return {.name = std::move(name),
            .checked = std::move(checked),
            .value = short_text(value),
            .bound = "≥ " + short_text(bound),
            .pass = value >= bound};
}

StabilityReport run_stability_study(const std::filesystem::path& out, bool full,
                                    const std::function<void(const std::string&)>& on_progress) {
    std::error_code ignored;  // the first file that cannot be written says what is wrong
    std::filesystem::create_directories(out, ignored);
    StabilityReport report;
    report.table.name = "stability";
    report.table.title = "Stiff and extreme cases";
    report.table.columns = {"case", "checked", "value", "bound", "pass", "z", "variance"};
    const auto add = [&](const std::vector<StabilityCase>& cases) {
        for (const StabilityCase& one : cases) {
            report.table.rows.push_back({one.name, one.checked, one.value, one.bound,
                                         one.pass ? "yes" : "NO",
                                         one.z ? study::decimals(*one.z, 2) : "-",
                                         one.variance ? short_text(*one.variance) : "-"});
            report.failed += one.pass ? 0 : 1;
        }
    };
    on_progress("media");
    add(media_cases());
    on_progress("voxels");
    add(voxel_cases(full));
    on_progress("input");
    add(input_cases());
    write_file_atomically(out / "stability.csv", report.table.csv());
    write_file_atomically(out / "stability.md", report.table.markdown());
    return report;
}

}  // namespace probebake::volume_study
