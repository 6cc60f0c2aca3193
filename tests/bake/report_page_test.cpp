#include "bake/report_page.h"
#include "bake/bake_probe.h"

#include <gtest/gtest.h>

#include "bake/bake_fixture.h"
#include "bake/report.h"

namespace probebake {
namespace {

Json report_of(const JobSpec& job) {
    const Scene scene = test::small_scene();
    const CancelToken cancel;
    const Plan plan = make_plan(scene, job);
    const std::vector<Pilot> pilots = {run_pilot(scene, job, plan, LightingState::kAlbedo, cancel)};
    const std::vector<ProbeResult> results = {bake_probe(scene, job, pilots[0], {}, cancel)};
    return write_report(
        {.scene = scene, .job = job, .plan = plan, .pilots = pilots, .results = results});
}

size_t count(const std::string& text, const std::string& what) {
    size_t n = 0;
    for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
    return n;
}

TEST(ReportPage, ShowsTheCurveWithItsTarget) {
    const Json report = report_of(test::small_job(1, {{"psnr_db", 30.0}}));
    const std::string page = report_page(report);
    const size_t points = report["states"][0]["curve"].size();
    EXPECT_GE(points, 5u);
    EXPECT_EQ(count(page, "<circle"), points);
    EXPECT_EQ(count(page, "class=\"chosen\""), 1u);
    EXPECT_EQ(count(page, "class=\"target\""), 1u);
    EXPECT_EQ(count(page, "target: psnr_db 30"), 1u);
    EXPECT_EQ(count(page, "<svg"), count(page, "</svg>"));
    // Nothing is loaded and nothing runs.
    for (const char* word : {"<script", "http", "src=", "href=", "@import", "url("}) {
        EXPECT_EQ(count(page, word), 0u) << word;
    }
}

TEST(ReportPage, TheTargetLiesWhereItBelongs) {
    Json report = report_of(test::small_job(1, {{"rmse", 0.1}}));
    Json& curve = report["states"][0]["curve"];
    curve.erase(curve.begin() + 1, curve.end());
    curve[0]["error"]["rmse"] = 0.1;
    curve[0]["error"]["rmse_interval"] = {0.09, 0.11};
    const std::string page = report_page(report);
    const auto after = [&](const std::string& from, const std::string& name) {
        const size_t at = page.find(name + "=\"", page.find(from)) + name.size() + 2;
        return page.substr(at, page.find('"', at) - at);
    };
    // A point on the target lies on its line.
    EXPECT_EQ(after("<circle", "cy"),
              page.substr(page.rfind("y1=\"", page.find("class=\"target\"")) + 4,
                          after("<circle", "cy").size()));
}

TEST(ReportPage, EscapesWhatItShows) {
    Json report = report_of(test::small_job(1, {{"rays", 9000}}));
    report["scene"]["name"] = "<script>alert('x')</script>";
    report["warnings"] = {"a & b \"c\""};
    const std::string page = report_page(report);
    EXPECT_EQ(count(page, "<script"), 0u);
    EXPECT_EQ(count(page, "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;"), 2u);
    EXPECT_EQ(count(page, "a &amp; b &quot;c&quot;"), 1u);
}

TEST(ReportPage, RefusesWhatIsNoReport) {
    for (const char* text : {"{}", "[]", "null", R"({"scene": {}, "target": {}, "totals": {}})"}) {
        EXPECT_THROW(report_page(Json::parse(text)), SpecError) << text;
    }
}

TEST(ReportPage, NamesProbesInInvalidPlaces) {
    Json report = report_of(test::small_job(1, {{"rays", 9000}}));
    EXPECT_EQ(count(report_page(report), "Places of probes"), 0u);
    report["validity"] = {{"probes", 12},
                          {"invalid", 3},
                          {"moved", 2},
                          {"invalid_probes", {"a", "b"}},
                          {"object_octree", nullptr},
                          {"seconds", 0.1}};
    const std::string page = report_page(report);
    EXPECT_EQ(count(page, "12 probes, 2 of them moved, 3 invalid."), 1u);
    EXPECT_EQ(count(page, "<span class=\"invalid\">"), 2u);
    EXPECT_EQ(count(page, "</span> …"), 1u);
}

}  // namespace
}  // namespace probebake
