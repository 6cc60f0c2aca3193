#include "http/router.h"

#include <gtest/gtest.h>

#include "http/query.h"

namespace probebake {
namespace {

Router bakes() {
    Router router;
    router.add("POST", "/v1/bakes");
    router.add("POST", "/v1/bakes:check");
    router.add("GET", "/v1/bakes");
    router.add("GET", "/v1/bakes/{id}");
    router.add("POST", "/v1/bakes/{id}:cancel");
    router.add("GET", "/v1/bakes/{id}/probes/{probe}/{state}/{file}");
    return router;
}

TEST(Router, FindsRoutesAndTheirParameters) {
    const Router router = bakes();
    EXPECT_EQ(router.find("POST", "/v1/bakes").route, 0U);
    EXPECT_EQ(router.find("POST", "/v1/bakes:check").route, 1U);
    EXPECT_EQ(router.find("GET", "/v1/bakes").route, 2U);
    EXPECT_EQ(router.find("HEAD", "/v1/bakes").route, 2U);
    EXPECT_EQ(router.find("GET", "/v1/bakes/b-1").params.at("id"), "b-1");
    EXPECT_EQ(router.find("POST", "/v1/bakes/b-1:cancel").route, 4U);
    EXPECT_EQ(router.find("POST", "/v1/bakes/b-1:cancel").params.at("id"), "b-1");
    const Router::Match file = router.find("GET", "/v1/bakes/b-1/probes/p/albedo/cube.exr");
    EXPECT_EQ(file.params.at("probe"), "p");
    EXPECT_EQ(file.params.at("file"), "cube.exr");
}

TEST(Router, KnowsTheMethodsOfAPath) {
    const Router router = bakes();
    EXPECT_EQ(router.find("DELETE", "/v1/bakes").allow, "POST, GET, HEAD");
    EXPECT_FALSE(router.find("DELETE", "/v1/bakes").route);
    EXPECT_EQ(router.find("GET", "/v1/bakes/b-1:cancel").allow, "POST");
    EXPECT_EQ(router.find("POST", "/v1/bakes/b-1").allow, "GET, HEAD");
}

TEST(Router, OtherPathsAreUnknown) {
    const Router router = bakes();
    for (const char* path :
         {"", "/", "//", "/v1", "/v1/bakes/", "/v1//bakes", "/v1/bakes//", "/v1/bakes/b-1/",
          "/v1/bakes/:cancel", "/v1/bakes/a:b:cancel", "/v1/bakes/b-1/probes/p/albedo",
          "/v1/bakes/../../etc/passwd", "/V1/bakes", "v1/bakes"}) {
        EXPECT_EQ(router.find("GET", path).allow, "") << path;
        EXPECT_EQ(router.find("POST", path).allow, "") << path;
    }
}

std::string problem_of_query(const httplib::Params& params) {
    httplib::Request request;
    request.params = params;
    try {
        QueryReader query(request);
        query.integer("page_size", 1, 100, 20);
        query.refuse_unknown();
    } catch (const SpecError& error) {
        return error.what();
    }
    return "none";
}

TEST(Query, IsReadStrictly) {
    EXPECT_EQ(problem_of_query({}), "none");
    EXPECT_EQ(problem_of_query({{"page_size", "100"}}), "none");
    for (const char* value :
         {"", "0", "101", "-1", "+5", "5.0", "1e1", " 5", "5 ", "five", "18446744073709551621"}) {
        EXPECT_EQ(problem_of_query({{"page_size", value}}),
                  "?page_size: expected an integer from 1 to 100")
            << value;
    }
    EXPECT_EQ(problem_of_query({{"page_size", "5"}, {"page_size", "6"}}),
              "?page_size: is repeated");
    EXPECT_EQ(problem_of_query({{"size", "5"}}), "?size: is unknown, expected only: page_size");
}

}  // namespace
}  // namespace probebake
