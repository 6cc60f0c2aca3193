#include "study/thesis_check.h"

#include <algorithm>
#include <cmath>

namespace probebake::study {
namespace {

constexpr int64_t kPixels = int64_t{512} * 512;

std::string in_thousands(int64_t x) {
    std::string digits = std::to_string(std::abs(x));
    for (size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
    return (x < 0 ? "−" : "") + digits;
}

std::string counted(uint64_t x) { return in_thousands(static_cast<int64_t>(x)); }

/// Table 5.27 repeats the row of table 5.1 whose decay is 0.2.
void compare_threshold_tables(std::vector<std::string>& found) {
    const auto& decay_row = thesis_decay_rays()[3];
    std::string pairs;
    int differing = 0;
    for (size_t i = 0; i < decay_row.size(); ++i) {
        const uint64_t other = thesis_thresholds()[i].rays;
        if (other == decay_row[i]) continue;
        ++differing;
        pairs += (pairs.empty() ? "" : ", ") + counted(decay_row[i]) + "/" + counted(other);
    }
    found.push_back("tables 5.1 and 5.27 give the same rays (desert, decay 0.2), but " +
                    std::to_string(differing) + " of 6 cells differ: " + pairs);
}

void check_range(std::vector<std::string>& found) {
    const PossibleRays possible = possible_desert_rays();
    int below = 0;
    int above = 0;
    const auto look = [&](uint64_t rays) {
        below += rays < possible.fewest ? 1 : 0;
        above += rays > possible.most ? 1 : 0;
    };
    for (const auto& row : thesis_decay_rays()) {
        for (const uint64_t rays : row) look(rays);
    }
    for (const ThesisThreshold& row : thesis_thresholds()) look(row.rays);
    found.push_back("of the cells of 5.1 and 5.27, " + std::to_string(below) +
                    " lie below one ray per pixel that hits (" + counted(possible.fewest) +
                    ") and " + std::to_string(above) + " above 21 (" + counted(possible.most) +
                    ")");
}

void check_adaptive(std::vector<std::string>& found) {
    std::string ten_steps;
    std::string with_first;
    std::string without_first;
    std::string missing;
    for (const ThesisArea& area : thesis_areas()) {
        const ThesisRenderer& a = area.adaptive;
        const auto append = [&](std::string& list, const std::string& text) {
            list += (list.empty() ? "" : ", ") + text;
        };
        if (a.steps == 10 * a.rays) append(ten_steps, area.name);
        const uint64_t kept = a.classes[1] + 4 * a.classes[2] + 16 * a.classes[3];
        const uint64_t first = a.classes[2] + a.classes[3];
        const auto difference = [&](uint64_t counts) {
            return std::abs(static_cast<int64_t>(counts) - static_cast<int64_t>(a.rays));
        };
        append(difference(kept) < difference(kept + first) ? without_first : with_first, area.name);
        const int64_t sum =
            static_cast<int64_t>(a.classes[0] + a.classes[1] + a.classes[2] + a.classes[3]);
        if (sum != kPixels) append(missing, in_thousands(sum - kPixels) + " (" + area.name + ")");
    }
    found.push_back("adaptive steps are exactly 10 times the rays: " + ten_steps);
    found.push_back("the adaptive renderer's first rays of refined pixels are counted on " +
                    with_first + " and not on " + without_first + ", by its classes of pixels");
    found.push_back("the adaptive renderer's classes of pixels miss 512² by " + missing);
}

}  // namespace

PossibleRays possible_desert_rays() {
    const uint64_t hit_pixels =
        static_cast<uint64_t>(kPixels) - thesis_areas()[0].error_aware.classes[0];
    return {hit_pixels, 21 * hit_pixels};
}

ThesisOwnCases thesis_own_cases() {
    ThesisOwnCases own{.lowest_ratio = 1e9};
    const auto add = [&](double ratio, bool cheaper_or_equal) {
        own.lowest_ratio = std::min(own.lowest_ratio, ratio);
        own.highest_ratio = std::max(own.highest_ratio, ratio);
        own.mean_ratio += ratio;
        ++own.cases;
        own.cheaper_or_equal += cheaper_or_equal ? 1 : 0;
    };
    for (const ThesisArea& area : thesis_areas()) {
        add(area.error_aware.rmse / area.adaptive.rmse,
            area.error_aware.steps <= area.adaptive.steps);
        for (const ThesisTimeOfDay& time : area.times) {
            add(time.error_aware_rmse / time.adaptive_rmse,
                time.error_aware_steps <= time.adaptive_steps);
        }
    }
    own.mean_ratio /= own.cases;
    return own;
}

std::vector<std::string> thesis_inconsistencies() {
    std::vector<std::string> found;
    compare_threshold_tables(found);
    check_range(found);
    check_adaptive(found);
    const uint64_t mountain = thesis_areas()[2].adaptive.rays;
    found.push_back("table 5.17 (biomes) is captioned Mountain; section 5.3.2 quotes " +
                    counted(mountain) + " rays for the forest, which is the mountain's count (" +
                    counted(thesis_areas()[1].adaptive.rays) + " is the forest's)");
    const ThesisOwnCases own = thesis_own_cases();
    found.push_back("\"higher performance in almost every test-case\" (chapter 7): in its own " +
                    std::to_string(own.cases) +
                    " cases error-aware rendering takes no more steps than adaptive in " +
                    std::to_string(own.cheaper_or_equal));
    return found;
}

}  // namespace probebake::study
