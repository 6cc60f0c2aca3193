#include "study/calibration/calibration_report.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <map>

#include "io/file.h"
#include "study/text_table.h"

namespace probebake::study {
namespace {

constexpr double kPromised = 0.95;

/// Hits of a share that is promised to be 95 %.
struct Share {
    uint64_t hits = 0;
    uint64_t count = 0;

    void add(bool hit) {
        hits += hit ? 1 : 0;
        ++count;
    }
    Json json() const {
        if (count == 0) return nullptr;
        const double p = binomial_tail(hits, count, kPromised);
        return {{"hits", hits},
                {"of", count},
                {"share", static_cast<double>(hits) / static_cast<double>(count)},
                {"p", p},
                {"holds", p >= 0.01}};
    }
};

bool inside(const Json& interval, double value) {
    return interval[0].get<double>() <= value && value <= interval[1].get<double>();
}

/// Far over near end of an interval of RMSE; infinite where the near end is 0.
double width(const Json& interval) {
    return std::sqrt(interval[1].get<double>() / std::max(0.0, interval[0].get<double>()));
}

Json median(std::vector<double> values) {
    if (values.empty()) return nullptr;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return std::isfinite(*middle) ? Json(*middle) : Json(nullptr);
}

/// Figures of some jobs.
class Group {
  public:
    void add(const Json& job) {
        const double allowed = job["allowed"];
        pilot_ += job["pilot_steps"].get<double>();
        one_price_ += job["one_price_steps"].get<double>();
        for_the_mean_ += job["one_price_for_the_mean_steps"].get<double>();
        for (const Json& row : job["rows"]) add(row, allowed);
    }

    Json json() const {
        const double with_replaced = render_ + replaced_;
        return {{"results", results_.count},
                {"said_met", said_},
                {"by_the_probe", by_probe_},
                {"met_where_said", met_where_said_.json()},
                {"met", results_.json()},
                {"own_interval_covers", own_.json()},
                {"pooled_interval_covers", pooled_.json()},
                {"own_interval_high_over_low", median(own_widths_)},
                {"pooled_interval_high_over_low", median(pooled_widths_)},
                {"mean_estimate_over_truth", estimate_ / own_truth_},
                {"mean_pooled_estimate_over_truth", pooled_estimate_ / truth_},
                {"looks", looks_ / static_cast<double>(results_.count)},
                {"audit_over_render", audit_ / render_},
                {"pilot_over_render", pilot_ / render_},
                {"over_cheapest_of_each",
                 {{"render", with_replaced / cheapest_},
                  {"with_audit", (with_replaced + audit_) / cheapest_},
                  {"with_audit_and_pilot", (with_replaced + audit_ + pilot_) / cheapest_}}},
                {"over_one_price",
                 {{"render", with_replaced / one_price_},
                  {"with_audit", (with_replaced + audit_) / one_price_},
                  {"with_audit_and_pilot", (with_replaced + audit_ + pilot_) / one_price_}}},
                {"over_one_price_for_the_mean", {{"render", with_replaced / for_the_mean_}}}};
    }

  private:
    void add(const Json& row, double allowed) {
        const double mse = row["mse"];
        const bool meets = mse <= allowed;
        results_.add(meets);
        if (row["met"].get<bool>()) {
            ++said_;
            by_probe_ += row["by_probe"].get<bool>() ? 1 : 0;
            met_where_said_.add(meets);
        }
        truth_ += mse / allowed;
        if (row.contains("interval")) {
            own_.add(inside(row["interval"], mse));
            own_widths_.push_back(width(row["interval"]));
            own_truth_ += mse / allowed;
            estimate_ += row["estimate"].get<double>() / allowed;
        }
        if (row.contains("pooled_interval")) {
            pooled_.add(inside(row["pooled_interval"], mse));
            pooled_widths_.push_back(width(row["pooled_interval"]));
            pooled_estimate_ += row["pooled_estimate"].get<double>() / allowed;
        }
        looks_ += row["looks"].get<double>();
        render_ += row["render_steps"].get<double>();
        replaced_ += row["replaced_steps"].get<double>();
        audit_ += row["audit_steps"].get<double>();
        cheapest_ += row["cheapest_steps"].get<double>();
    }

    Share results_;
    Share met_where_said_;
    Share own_;
    Share pooled_;
    uint64_t said_ = 0;
    uint64_t by_probe_ = 0;
    std::vector<double> own_widths_;
    std::vector<double> pooled_widths_;
    double truth_ = 0.0;
    double own_truth_ = 0.0;  // where it was audited itself
    double estimate_ = 0.0;
    double pooled_estimate_ = 0.0;
    double looks_ = 0.0;
    double render_ = 0.0;
    double replaced_ = 0.0;
    double audit_ = 0.0;
    double pilot_ = 0.0;
    double cheapest_ = 0.0;
    double one_price_ = 0.0;
    double for_the_mean_ = 0.0;
};

std::string share_text(const Json& share) {
    if (share.is_null()) return "-";
    return decimals(100.0 * share["share"].get<double>(), 1) + " % of " +
           grouped_digits(share["of"]) + ", p " + decimals(share["p"].get<double>(), 3);
}

std::string number(const Json& value, int places) {
    return value.is_null() ? "-" : decimals(value.get<double>(), places);
}

TextTable promises(const Json& summary) {
    TextTable table{.name = "promises",
                    .title = "What was promised and what is true",
                    .columns = {"jobs", "results", "said to meet the target", "by their own audit",
                                "of these, do meet it", "of all, meet it", "own intervals cover",
                                "intervals with the job's audits cover"}};
    for (const auto& [name, group] : summary.items()) {
        table.rows.push_back(
            {name, grouped_digits(group["results"]), grouped_digits(group["said_met"]),
             grouped_digits(group["by_the_probe"]), share_text(group["met_where_said"]),
             share_text(group["met"]), share_text(group["own_interval_covers"]),
             share_text(group["pooled_interval_covers"])});
    }
    return table;
}

TextTable widths(const Json& summary) {
    TextTable table{.name = "intervals",
                    .title = "Intervals: far over near end in RMSE, median; estimates over truth",
                    .columns = {"jobs", "own", "with the job's audits", "mean own estimate",
                                "mean estimate with the job's", "looks"}};
    for (const auto& [name, group] : summary.items()) {
        table.rows.push_back({name, number(group["own_interval_high_over_low"], 2),
                              number(group["pooled_interval_high_over_low"], 2),
                              number(group["mean_estimate_over_truth"], 3),
                              number(group["mean_pooled_estimate_over_truth"], 3),
                              number(group["looks"], 2)});
    }
    return table;
}

TextTable costs(const Json& summary) {
    TextTable table{
        .name = "costs",
        .title = "Steps over those of the cheapest prices that would have met the target",
        .columns = {"jobs", "audit / render", "pilot / render", "each probe's own price: render",
                    "with audit", "with audit and pilot", "one price for 95 % of a job: render",
                    "with audit", "with audit and pilot", "one price for the mean: render"}};
    for (const auto& [name, group] : summary.items()) {
        const Json& each = group["over_cheapest_of_each"];
        const Json& one = group["over_one_price"];
        table.rows.push_back({name, number(group["audit_over_render"], 3),
                              number(group["pilot_over_render"], 3), number(each["render"], 2),
                              number(each["with_audit"], 2),
                              number(each["with_audit_and_pilot"], 2), number(one["render"], 2),
                              number(one["with_audit"], 2), number(one["with_audit_and_pilot"], 2),
                              number(group["over_one_price_for_the_mean"]["render"], 2)});
    }
    return table;
}

}  // namespace

double binomial_tail(uint64_t hits, uint64_t n, double probability) {
    const boost::math::binomial_distribution<double> binomial(static_cast<double>(n), probability);
    return boost::math::cdf(binomial, static_cast<double>(hits));
}

Json summarise_calibration(const Json& results) {
    std::map<std::string, Group> groups;
    for (const auto& [name, job] : results.items()) {
        groups["all"].add(job);
        groups["faces of " + std::to_string(job["face_size_px"].get<int>()) + "²"].add(job);
        groups[job["lit"].get<bool>() ? "lit" : "unlit"].add(job);
        groups[job["scene"].get<std::string>()].add(job);
    }
    Json summary = Json::object();
    for (const auto& [name, group] : groups) summary[name] = group.json();
    return summary;
}

void write_calibration_report(const CalibrationParams& params, const CalibrationOutcome& outcome) {
    std::string text = "# Are promises kept?\n\n" + std::to_string(outcome.results.size()) +
                       " jobs, generated worlds of " + std::to_string(params.size) +
                       "³. p: one-sided binomial test of 95 %.\n";
    for (const std::string& left : outcome.left_out) text += "\nLeft out: " + left + "\n";
    std::filesystem::create_directories(params.out / "tables");
    for (const TextTable& table :
         {promises(outcome.summary), widths(outcome.summary), costs(outcome.summary)}) {
        write_file_atomically(params.out / "tables" / (table.name + ".csv"), table.csv());
        text += "\n## " + table.title + "\n\n" + table.markdown();
    }
    write_file_atomically(params.out / "report.md", text);
}

}  // namespace probebake::study
