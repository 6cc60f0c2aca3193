#include "bake/report_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "io/spec_error.h"

namespace probebake {
namespace {

constexpr double kWidth_px = 640.0;
constexpr double kHeight_px = 400.0;
constexpr double kLeft_px = 76.0;
constexpr double kRight_px = 16.0;
constexpr double kTop_px = 16.0;
constexpr double kBottom_px = 52.0;
/// As a state's summary names them.
constexpr std::array<std::pair<const char*, const char*>, 5> kMetrics = {
    {{"rmse", "RMSE"},
     {"psnr_db", "PSNR in dB"},
     {"ssim", "SSIM"},
     {"rel_mse", "relative squared error"},
     {"irradiance_rel", "relative error of irradiance"}}};

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            case '\'':
                out += "&#39;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

std::string text_of(const Json& value) {
    if (value.is_null()) return "–";
    return escaped(value.is_string() ? value.get<std::string>() : value.dump());
}

std::string number(double x, int digits = 3) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.*g", digits, x);
    return buffer.data();
}
std::string number(const Json& x, int digits = 3) {
    return x.is_number() ? number(x.get<double>(), digits) : "–";
}
std::string pixels(double x) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.1f", x);
    return buffer.data();
}

/// What a plot shows of an error, and where the target lies.
struct Measure {
    std::string name;  // key of report errors
    std::string label;
    double target = 0.0;
    std::string target_label;
};

Measure measure_of(const Json& target) {
    const auto metric = target.at("metric").get<std::string>();
    const auto value = target.at("value").get<double>();
    const std::string label = "target: " + metric + " " + number(value, 6);
    if (metric == "psnr_db") return {"rmse", "RMSE", std::pow(10.0, -value / 20.0), label};
    if (metric == "rmse") return {"rmse", "RMSE", value, label};
    if (metric == "rel_mse") return {"rel_mse", "rel_mse", value, label};
    if (metric == "ssim") return {"ssim", "1 − SSIM", 1.0 - value, label};
    if (metric == "irradiance_rel") return {metric, metric, value, label};
    return {"rmse", "RMSE", 0.0, {}};  // of rays: nothing to reach
}

struct Point {
    double seconds = 0.0;
    double error = 0.0;
    double low = 0.0;
    double high = 0.0;
    bool chosen = false;
    std::string title;
};

std::string settings_text(const Json& settings) {
    std::string text;
    for (const auto& [name, value] : settings.items()) {
        if (!text.empty()) text += ", ";
        text += name == "renderer" ? text_of(value) : escaped(name) + " " + number(value);
        if (name != "renderer" && !value.is_number()) text += text_of(value);
    }
    return text;
}

std::vector<Point> points_of(const Json& curve, const Measure& measure) {
    std::vector<Point> points;
    for (const Json& at : curve) {
        const Json& error = at.at("error");
        if (!error.contains(measure.name)) continue;
        Point point{.seconds = at.at("seconds").get<double>(),
                    .error = error.at(measure.name).get<double>(),
                    .low = error.at(measure.name + "_interval").at(0).get<double>(),
                    .high = error.at(measure.name + "_interval").at(1).get<double>(),
                    .chosen = at.at("chosen").get<bool>(),
                    .title = settings_text(at.at("settings"))};
        if (measure.name == "ssim") {
            point.error = 1.0 - point.error;
            const double low = 1.0 - point.high;
            point.high = 1.0 - point.low;
            point.low = low;
        }
        // A logarithm shows neither; the table does.
        if (point.seconds > 0.0 && point.error > 0.0) points.push_back(point);
    }
    return points;
}

/// A logarithmic axis over whole decades.
class Axis {
  public:
    Axis(double low, double high, double from_px, double to_px)
        : first_(std::floor(std::log10(low))),
          last_(std::max(first_ + 1.0, std::ceil(std::log10(high)))),
          from_px_(from_px),
          to_px_(to_px) {}

    double at(double value) const {
        const double share = (std::log10(value) - first_) / (last_ - first_);
        return from_px_ + std::clamp(share, 0.0, 1.0) * (to_px_ - from_px_);
    }
    /// Calls visit(value, whether it begins a decade).
    template <class Visit>
    void for_each_tick(Visit visit) const {
        for (double decade = first_; decade <= last_; decade += 1.0) {
            for (int i = 1; i < 10 && (i == 1 || decade < last_); ++i) {
                visit(i * std::pow(10.0, decade), i == 1);
            }
        }
    }

  private:
    double first_;
    double last_;
    double from_px_;
    double to_px_;
};

std::string line(double x0, double y0, double x1, double y1, const char* style) {
    return "<line x1=\"" + pixels(x0) + "\" y1=\"" + pixels(y0) + "\" x2=\"" + pixels(x1) +
           "\" y2=\"" + pixels(y1) + "\" class=\"" + style + "\"/>\n";
}

std::string label(double x, double y, const char* style, const std::string& text) {
    return "<text x=\"" + pixels(x) + "\" y=\"" + pixels(y) + "\" class=\"" + style + "\">" + text +
           "</text>\n";
}

std::string plot(const std::vector<Point>& points, const Measure& measure) {
    double low = measure.target > 0.0 ? measure.target : points.front().error;
    double high = low;
    double fast = points.front().seconds;
    double slow = fast;
    for (const Point& point : points) {
        low = std::min(low, point.error);
        high = std::max(high, point.high);
        fast = std::min(fast, point.seconds);
        slow = std::max(slow, point.seconds);
    }
    const double bottom = kHeight_px - kBottom_px;
    const double right = kWidth_px - kRight_px;
    const Axis x(fast, slow, kLeft_px, right);
    const Axis y(low / 2.0, high, bottom, kTop_px);
    std::string svg = "<svg viewBox=\"0 0 " + pixels(kWidth_px) + " " + pixels(kHeight_px) +
                      "\" role=\"img\" aria-label=\"error against run time\">\n";
    x.for_each_tick([&](double value, bool decade) {
        svg += line(x.at(value), kTop_px, x.at(value), bottom, decade ? "decade" : "tick");
        if (decade) svg += label(x.at(value), bottom + 18.0, "middle", number(value) + " s");
    });
    y.for_each_tick([&](double value, bool decade) {
        svg += line(kLeft_px, y.at(value), right, y.at(value), decade ? "decade" : "tick");
        if (decade) svg += label(kLeft_px - 8.0, y.at(value) + 4.0, "end", number(value));
    });
    if (measure.target > 0.0) {
        const double at = y.at(measure.target);
        svg += line(kLeft_px, at, right, at, "target");
        svg += label(right - 4.0, at - 5.0, "end targetlabel", escaped(measure.target_label));
    }
    std::string path;
    for (const Point& point : points) {
        path += (path.empty() ? "M" : " L") + pixels(x.at(point.seconds)) + " " +
                pixels(y.at(point.error));
    }
    svg += "<path d=\"" + path + "\" class=\"curve\"/>\n";
    for (const Point& point : points) {
        const double at = x.at(point.seconds);
        const double bar = point.low > 0.0 ? y.at(point.low) : bottom;
        svg += line(at, bar, at, y.at(point.high), "interval");
        svg += "<circle cx=\"" + pixels(at) + "\" cy=\"" + pixels(y.at(point.error)) + "\" r=\"" +
               (point.chosen ? "6" : "4") + "\" class=\"" + (point.chosen ? "chosen" : "point") +
               "\"><title>" + point.title + ": " + number(point.error) + " in " +
               number(point.seconds) + " s</title></circle>\n";
    }
    svg += label((kLeft_px + right) / 2.0, kHeight_px - 10.0, "middle",
                 "seconds of one thread on the pilot's pixels");
    svg += "<text transform=\"translate(16 " + pixels((kTop_px + bottom) / 2.0) +
           ") rotate(-90)\" class=\"middle\">" + escaped(measure.label) + "</text>\n</svg>\n";
    return svg;
}

std::string row(const std::vector<std::string>& cells, const char* tag = "td") {
    std::string html = "<tr>";
    for (const std::string& cell : cells) {
        html += std::string("<") + tag + ">" + cell + "</" + tag + ">";
    }
    return html + "</tr>\n";
}

std::string interval_text(const Json& error, const std::string& name) {
    if (!error.contains(name)) return "–";
    const Json& ends = error.at(name + "_interval");
    return number(error.at(name)) + " [" + number(ends.at(0)) + ", " + number(ends.at(1)) + "]";
}

std::string curve_table(const Json& curve, const Measure& measure) {
    std::string html = "<table>\n" + row({"settings", "rays", "steps", "seconds",
                                          escaped(measure.name) + " [95 %]", "PSNR, dB"},
                                         "th");
    for (const Json& at : curve) {
        const Json& error = at.at("error");
        html += row({settings_text(at.at("settings")) + (at.at("chosen").get<bool>() ? " ●" : ""),
                     number(at.at("rays"), 9), number(at.at("steps"), 9), number(at.at("seconds")),
                     interval_text(error, measure.name), interval_text(error, "psnr_db")});
    }
    return html + "</table>\n";
}

std::string state_section(const Json& state, const Json& target) {
    const Json& cost = state.at("cost");
    std::string html = "<section>\n<h2>" + text_of(state.at("state")) + "</h2>\n<p>";
    for (const auto& [verdict, count] : state.at("results").items()) {
        html += escaped(verdict) + ": " + text_of(count) + ". ";
    }
    if (state.contains("error")) {
        const Json& error = state.at("error");
        html += "All probes:";
        const char* separator = " ";
        for (const auto& [name, label] : kMetrics) {
            if (!error.contains(name)) continue;
            html += std::string(separator) + label + " " + interval_text(error, name);
            separator = ", ";
        }
        html += ". ";
    }
    html += "Pilot " + number(100.0 * cost.at("pilot_steps_over_render").get<double>()) +
            " % and audits " + number(100.0 * cost.at("audit_steps_over_render").get<double>()) +
            " % of the render's steps; " + number(cost.at("rays_per_pixel")) +
            " rays per pixel.</p>\n";
    for (const Json& one : target.at("targets")) {
        const Measure measure = measure_of(one);
        const std::vector<Point> points = points_of(state.at("curve"), measure);
        if (points.empty()) {
            html += "<p>There is no curve for " + text_of(one.at("metric")) + ".</p>\n";
            continue;
        }
        html += "<figure>\n" + plot(points, measure) +
                "<figcaption>Error against run time, measured on the pilot's pixels; bars are "
                "intervals, the large mark is what the pilot chose.</figcaption>\n</figure>\n" +
                curve_table(state.at("curve"), measure);
    }
    return html + "</section>\n";
}

/// Empty where every probe stands as requested, in a valid place.
std::string places_section(const Json& validity) {
    const Json& invalid = validity.at("invalid_probes");
    if (invalid.empty() && validity.at("moved") == 0) return "";
    std::string html = "<section>\n<h2>Places of probes</h2>\n<p>" +
                       number(validity.at("probes"), 9) + " probes, " +
                       number(validity.at("moved"), 9) + " of them moved, " +
                       number(validity.at("invalid"), 9) + " invalid.</p>\n";
    if (!invalid.empty()) {
        html += "<p>Invalid:";
        for (const Json& id : invalid) {
            html += " <span class=\"invalid\">" + text_of(id) + "</span>";
        }
        if (validity.at("invalid") > invalid.size()) html += " …";
        html += "</p>\n";
    }
    return html + "</section>\n";
}

constexpr const char* kStyle =
    "body{font:15px/1.5 sans-serif;color:#222;max-width:48rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse;font-size:13px;margin:1rem 0}"
    "th,td{padding:2px 10px;text-align:right;border-bottom:1px solid #ddd}"
    "th:first-child,td:first-child{text-align:left}figure{margin:1rem 0}"
    "figcaption{font-size:13px;color:#555}svg{width:100%;font:12px sans-serif}"
    ".tick{stroke:#eee}.decade{stroke:#ccc}.middle{text-anchor:middle}.end{text-anchor:end}"
    ".target{stroke:#c03030;stroke-dasharray:6 4;stroke-width:1.5}.targetlabel{fill:#c03030}"
    ".curve{fill:none;stroke:#2060a0;stroke-width:1.5}.interval{stroke:#2060a0;opacity:.4;"
    "stroke-width:3}.invalid{color:#c03030}.point{fill:#2060a0}.chosen{fill:#fff;stroke:#2060a0;"
    "stroke-width:3}";

std::string page(const Json& report) {
    const Json& scene = report.at("scene");
    const Json& target = report.at("target");
    const Json& totals = report.at("totals");
    std::string wanted;
    for (const Json& one : target.at("targets")) {
        if (!wanted.empty()) wanted += target.at("require") == "all" ? " and " : " or ";
        wanted += text_of(one.at("metric")) + " " + number(one.at("value"), 6);
    }
    const std::string name = text_of(scene.at("name"));
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                       name + ": report</title><style>" + kStyle + "</style></head><body>\n<h1>" +
                       name + "</h1>\n<p>" + number(scene.at("voxels"), 12) + " voxels. Target " +
                       wanted + " against " + text_of(target.at("against")) + ", confidence " +
                       number(target.at("confidence"), 4) + ". " +
                       number(totals.at("cubemaps"), 9) + " cubemaps in " +
                       number(totals.at("wall_seconds")) + " s of wall time.</p>\n";
    html += places_section(report.at("validity"));
    for (const Json& state : report.at("states")) html += state_section(state, target);
    if (!report.at("warnings").empty()) {
        html += "<h2>Warnings</h2>\n<ul>\n";
        for (const Json& warning : report.at("warnings")) {
            html += "<li>" + text_of(warning) + "</li>\n";
        }
        html += "</ul>\n";
    }
    const Json& made = report.at("provenance");
    return html + "<p><small>probebake " + text_of(made.at("version")) + ", scene " +
           text_of(scene["sha256"]) + "</small></p>\n</body></html>\n";
}

}  // namespace

std::string report_page(const Json& report) {
    try {
        return page(report);
    } catch (const Json::exception& error) {
        throw SpecError(SpecError::Kind::kMalformed, "",
                        std::string("expected a report of probebake: ") + error.what());
    }
}

}  // namespace probebake
