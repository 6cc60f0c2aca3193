// The request as openapi.json describes it and as read_job reads it: the same fields, ranges and
// words.
#include <gtest/gtest.h>

#include <map>

#include "bake/job_spec.h"
#include "openapi_check.h"

namespace probebake {
namespace {

/// Requests that between them have every field. Not all of it can be baked: what is refused for
/// other reasons than a field's own is of no interest here.
std::vector<Json> samples() {
    const Json light = {1, 2, 3};
    const auto lit = [](const char* id, const Json& sky) { return Json{{"id", id}, {"sky", sky}}; };
    Json day = lit(
        "day", {{"type", "constant"}, {"radiance_w_m2_sr", light}, {"rays", 8}, {"gather_m", 2}});
    day["sun"] = {{"direction", {1, 2, 1}},
                  {"irradiance_w_m2", light},
                  {"angular_diameter_deg", 0.5},
                  {"rays", 2}};
    day["emission"] = true;
    day["radiance_per"] = "face";
    day["shadows"] = {{"lod", "node"}, {"cone", 0.5}, {"threshold", 0.5}, {"decay", 0.5}};
    const Json dusk = lit("dusk", {{"type", "gradient"},
                                   {"zenith_w_m2_sr", light},
                                   {"horizon_w_m2_sr", light},
                                   {"ground_w_m2_sr", light}});
    const Json picture = lit(
        "picture", {{"type", "equirect"}, {"file", "a.hdr"}, {"scale", 2}, {"rotation_deg", 30}});
    const Json view = {{"face_size_px", 16}, {"near_m", 0.1}, {"far_m", 100}};
    Json probe = {{"id", "p"}, {"position_m", {1, 2, 3}}};
    Json grid = {
        {"id", "g"}, {"origin_m", {1, 2, 3}}, {"spacing_m", {1, 1, 1}}, {"counts", {2, 2, 2}}};
    probe.update(view);
    grid.update(view);
    Json request = view;
    request["scene"] = "net";
    request["seed"] = 5;
    request["lighting_states"] = {"albedo", "emission", day, dusk, picture};
    request["probes"] = {{"list", {probe}}, {"grids", {grid}}};
    request["products"] = {"cube", "aux"};
    request["validity"] = {
        {"max_backface", 0.5}, {"max_closed_in", 0.5}, {"relocate", true}, {"max_offset_m", 1}};
    request["quality"] = {
        {"targets",
         {{"psnr_db", 30},
          {"rmse", 0.1},
          {"ssim", 0.9},
          {"irradiance_rel", 0.1},
          {"rel_mse", 0.1}}},
        {"require", "all"},
        {"renderer", "error_aware"},
        {"tracker", "auto"},
        {"against", "truth"},
        {"weighting", "uniform"},
        {"exposure", 1},
        {"settings",
         {{"threshold", 0.1},
          {"decay", 0.1},
          {"leaf_grid", 4},
          {"price", 1},
          {"spread", 1},
          {"fixed_level", 3},
          {"normaliser", 1},
          {"misses_in_kernel", "black"}}},
        {"evidence", {{"audit", true}, {"pixels_per_probe", 64}, {"confidence", 0.9}}}};
    request["budget"] = {{"rays", 1'000'000'000}, {"seconds", 10}, {"memory_bytes", 1}};
    request["on_budget_exhausted"] = "fail";
    request["priority"] = 1;
    Json rays = request;
    rays["quality"]["targets"] = {{"rays", 100'000}};
    rays["quality"]["evidence"] = "none";
    return {request, rays};
}

/// What read_job has against a request, by pointer.
std::multimap<std::string, std::string> issues_of(const Json& request) {
    std::multimap<std::string, std::string> issues;
    try {
        read_job(request);
    } catch (const SpecError& error) {
        for (const SpecIssue& issue : error.issues()) issues.emplace(issue.pointer, issue.detail);
    }
    return issues;
}

std::set<std::string> words_of(const std::string& text, const std::string& begin) {
    std::set<std::string> words;
    if (text.rfind(begin, 0) != 0) return words;
    for (size_t at = begin.size(); at < text.size();) {
        const size_t end = std::min(text.find(", ", at), text.size());
        std::string word = text.substr(at, end - at);
        if (word.front() == '"') word = word.substr(1, word.size() - 2);
        words.insert(word);
        at = end + 2;
    }
    return words;
}

class Comparison {
  public:
    explicit Comparison(const Json& request) : request_(request) {}

    void of(const Json& given, const Json& value, const std::string& pointer,
            const std::string& place) {
        const Json& schema = api_.resolve(given);
        if (schema.contains("anyOf")) {
            for (const Json& one : schema["anyOf"]) {
                if (one.value("type", "") == value.type_name()) of(one, value, pointer, place);
            }
            return;
        }
        if (value.is_object()) of_object(schema, value, pointer, place);
        if (value.is_array()) {
            for (size_t i = 0; i < value.size(); ++i) {
                of(schema.at("items"), value[i], pointer + "/" + std::to_string(i), place + "/*");
            }
        }
        if (value.is_number()) of_number(schema, value, pointer);
        if (schema.contains("enum")) of_words(schema.at("enum"), pointer);
    }

    /// By place (a pointer with * for elements), what the reader knows and what is described.
    std::map<std::string, std::set<std::string>> read;
    std::map<std::string, std::set<std::string>> described;

  private:
    std::multimap<std::string, std::string> with(const std::string& pointer,
                                                 const Json& value) const {
        Json changed = request_;
        changed[Json::json_pointer(pointer)] = value;
        return issues_of(changed);
    }
    /// Within the field's own range; what only other fields forbid is described in words.
    void expect_taken(const std::string& pointer, const Json& value) const {
        const auto issues = with(pointer, value);
        const auto [begin, end] = issues.equal_range(pointer);
        for (auto at = begin; at != end; ++at) {
            const std::string& detail = at->second;
            EXPECT_TRUE(detail.rfind("is ", 0) != 0 && detail.rfind("expected one of ", 0) != 0)
                << pointer << " = " << value << ": " << detail;
        }
    }
    void expect_refused(const std::string& pointer, const Json& value) const {
        EXPECT_TRUE(with(pointer, value).contains(pointer)) << pointer << " = " << value;
    }

    void of_object(const Json& schema, const Json& value, const std::string& pointer,
                   const std::string& place) {
        EXPECT_EQ(schema.value("additionalProperties", true), false) << place;
        for (const auto& [detail_at, detail] : with(pointer + "/zz", 1)) {
            if (detail_at != pointer + "/zz") continue;
            read[place].merge(words_of(detail, "is unknown, expected only: "));
        }
        for (const auto& [key, part] : schema.at("properties").items())
            described[place].insert(key);
        for (const auto& [key, part] : value.items()) {
            ASSERT_TRUE(schema["properties"].contains(key)) << pointer << "/" << key;
            const std::string below = "/" + key;
            of(schema["properties"][key], part, pointer + below, place + below);
        }
    }
    void of_number(const Json& schema, const Json& value, const std::string& pointer) const {
        const bool integer = schema.at("type") == "integer";
        if (schema.contains("enum")) return;
        if (integer) {
            const auto issues = with(pointer, value.get<double>() + 0.5);
            EXPECT_TRUE(issues.contains(pointer)) << pointer << " is an integer";
        }
        if (schema.contains("minimum")) {
            expect_taken(pointer, schema["minimum"]);
            expect_refused(pointer, schema["minimum"].get<double>() - 1);
        } else {
            expect_refused(pointer, schema.at("exclusiveMinimum"));
        }
        if (schema.value("format", "") == "uint64") {
            expect_taken(pointer, ~uint64_t{0});
            return;
        }
        expect_taken(pointer, schema.at("maximum"));
        const Json above = integer ? Json(schema["maximum"].get<int64_t>() + 1)
                                   : Json(schema["maximum"].get<double>() * 1.001);
        expect_refused(pointer, above);
    }
    void of_words(const Json& words, const std::string& pointer) const {
        for (const Json& word : words) expect_taken(pointer, word);
        const Json unknown = words[0].is_string() ? Json("zz") : Json(5);
        const auto issues = with(pointer, unknown);
        const auto at = issues.find(pointer);
        ASSERT_TRUE(at != issues.end()) << pointer;
        const std::set<std::string> expected = words_of(at->second, "expected one of ");
        for (const std::string& word : expected) {
            EXPECT_NE(std::find(words.begin(), words.end(), word), words.end())
                << pointer << " may be " << word;
        }
    }

    const test::OpenApiCheck api_;
    const Json request_;
};

TEST(OpenApiRequest, IsTheOneThatIsRead) {
    std::map<std::string, std::set<std::string>> read;
    std::map<std::string, std::set<std::string>> described;
    for (const Json& sample : samples()) {
        const test::OpenApiCheck api;
        for (const std::string& problem : api.request_problems("POST", "/v1/bakes", sample)) {
            ADD_FAILURE() << problem;
        }
        Comparison comparison(sample);
        comparison.of(api.schema("BakeRequest"), sample, "", "");
        for (auto& [place, names] : comparison.read) read[place].merge(names);
        for (auto& [place, names] : comparison.described) described[place].merge(names);
    }
    EXPECT_EQ(described.size(), 14U) << "a sample has no object of a kind";
    for (const auto& [place, names] : described) {
        EXPECT_EQ(names, read[place]) << "described and read of " << place;
    }
}

}  // namespace
}  // namespace probebake
