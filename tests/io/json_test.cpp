#include "io/json.h"

#include <gtest/gtest.h>

namespace probebake {
namespace {

/// The issues of reading `text` with `read`, as "pointer: detail" lines; and the kind of the error.
template <class Read>
std::string problems(std::string_view text, Read read) {
    try {
        const Json document = parse_json(text);
        JsonIssues issues;
        ObjectReader reader(document, "", issues);
        read(reader);
        issues.throw_if_any();
    } catch (const SpecError& error) {
        return (error.kind() == SpecError::Kind::kMalformed ? "400 " : "422 ") +
               std::string(error.what());
    }
    return "none";
}

std::string syntax_problem(std::string_view text) {
    return problems(text, [](ObjectReader&) {});
}

TEST(Json, RefusesWhatIsNotOnePlainDocument) {
    EXPECT_EQ(syntax_problem("{}"), "none");
    EXPECT_EQ(syntax_problem(""), "400 (document): not JSON at byte 1");
    EXPECT_EQ(syntax_problem("{\"a\":}"), "400 (document): not JSON at byte 6");
    EXPECT_EQ(syntax_problem("{} {}"), "400 (document): not JSON at byte 4");
    EXPECT_EQ(syntax_problem("{\"a\":NaN}"), "400 (document): not JSON at byte 6");
    EXPECT_EQ(syntax_problem("{\"a\":1e999}"), "400 (document): a number is out of range");
    EXPECT_EQ(syntax_problem("{\"a\":1,\"a\":2}"), "400 (document): the key \"a\" is repeated");
    EXPECT_EQ(syntax_problem("{\"a\":{\"b\":1},\"c\":{\"b\":1}}"), "none");
    EXPECT_EQ(syntax_problem("\"\xff\""), "400 (document): not JSON at byte 2");
    EXPECT_EQ(syntax_problem("[]"), "400 (document): expected an object");
}

TEST(Json, RefusesDepthAndFloods) {
    const std::string deep = std::string(17, '[') + std::string(17, ']');
    EXPECT_EQ(syntax_problem(deep), "400 (document): nested deeper than 16");
    EXPECT_EQ(syntax_problem(std::string(1'000'000, '[')), "400 (document): nested deeper than 16");
    std::string wide = "[0";
    for (int i = 0; i < 200; ++i) wide += ",0";
    wide += "]";
    EXPECT_THROW(parse_json(wide, {.max_values = 100}), SpecError);
    EXPECT_NO_THROW(parse_json(wide, {.max_values = 300}));
}

TEST(Json, IntegersAreIntegersInRange) {
    const auto read = [](ObjectReader& r) { r.integer("n", 4, 4096, 64); };
    EXPECT_EQ(problems("{\"n\": 4}", read), "none");
    EXPECT_EQ(problems("{}", read), "none");
    const std::string expected = "expected an integer from 4 to 4096";
    EXPECT_EQ(problems("{\"n\": 64.7}", read), "400 /n: " + expected);
    EXPECT_EQ(problems("{\"n\": 64.0}", read), "400 /n: " + expected);
    EXPECT_EQ(problems("{\"n\": \"64\"}", read), "400 /n: " + expected);
    EXPECT_EQ(problems("{\"n\": null}", read), "400 /n: " + expected);
    EXPECT_EQ(problems("{\"n\": -1}", read), "422 /n: is -1, " + expected);
    EXPECT_EQ(problems("{\"n\": 18446744073709551615}", read),
              "422 /n: is 18446744073709551615, " + expected);
    const auto read_unsigned = [](ObjectReader& r) { r.unsigned_integer("n", 10, {}); };
    EXPECT_EQ(problems("{\"n\": -1}", read_unsigned),
              "422 /n: is -1, expected an integer from 0 to 10");
    EXPECT_EQ(problems("{}", read_unsigned), "400 /n: is required");
}

TEST(Json, NumbersAreFiniteAndInRange) {
    const auto read = [](ObjectReader& r) {
        r.number("x", {.min = 0.0, .max = 200.0, .more_than_min = true}, {});
    };
    EXPECT_EQ(problems("{\"x\": 40}", read), "none");
    EXPECT_EQ(problems("{\"x\": 0}", read),
              "422 /x: is 0, expected a number of more than 0 and at most 200");
    EXPECT_EQ(problems("{\"x\": 200.5}", read),
              "422 /x: is 200.5, expected a number of more than 0 and at most 200");
    EXPECT_EQ(problems("{\"x\": []}", read),
              "400 /x: expected a number of more than 0 and at most 200");
}

TEST(Json, NamesVectorsAndChoices) {
    const auto read = [](ObjectReader& r) {
        r.name("id", {});
        r.vector("at", 1e6, {});
        constexpr std::string_view kChoices[] = {"auto", "lod"};
        r.choice("renderer", kChoices, 0);
    };
    EXPECT_EQ(problems("{\"id\": \"a.b-c_0\", \"at\": [1, 2.5, -3]}", read), "none");
    EXPECT_NE(
        problems("{\"id\": \"../x\", \"at\": [1, 2, 3]}", read).find("400 /id: expected a name"),
        std::string::npos);
    EXPECT_EQ(problems("{\"id\": \"a\", \"at\": [1, 2]}", read),
              "400 /at: expected an array of three numbers");
    EXPECT_EQ(problems("{\"id\": \"a\", \"at\": [1, 2, 2e6]}", read),
              "422 /at/2: is 2e+06, expected a number of at least -1e+06 and at most 1e+06");
    EXPECT_EQ(problems("{\"id\": \"a\", \"at\": [1, 2, 3], \"renderer\": \"best\"}", read),
              "400 /renderer: expected one of \"auto\", \"lod\"");
    for (const char* bad : {"", "-a", "A", "a/b", "a b", "\xc3\xa9"}) EXPECT_FALSE(is_name(bad));
    EXPECT_FALSE(is_name(std::string(65, 'a')));
    EXPECT_TRUE(is_name(std::string(64, 'a')));
}

TEST(Json, ReportsEveryProblemAtOnceWithEscapedPointers) {
    const auto read = [](ObjectReader& r) {
        ObjectReader quality = r.object("quality");
        quality.integer("n", 0, 1, 0);
        quality.refuse_unknown();
        r.refuse_unknown();
    };
    EXPECT_EQ(problems("{\"quality\": {\"n\": 2, \"a/b~c\": 1}, \"extra\": 1}", read),
              "400 /quality/n: is 2, expected an integer from 0 to 1\n"
              "/quality/a~1b~0c: is unknown, expected only: n\n"
              "/extra: is unknown, expected only: quality");
    EXPECT_EQ(problems("{\"quality\": []}", read), "400 /quality: expected an object");
    EXPECT_EQ(problems("{\"quality\": null}", read), "400 /quality: expected an object");
}

TEST(Json, DumpsInvalidTextWithoutThrowing) {
    EXPECT_EQ(dump_json(Json("a\xff")), "\"a\xef\xbf\xbd\"");
}

}  // namespace
}  // namespace probebake
