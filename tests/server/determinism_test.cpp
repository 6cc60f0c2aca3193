// The same bytes, whoever bakes: through HTTP or without it, on any number of threads, before and
// after a restart.
#include <gtest/gtest.h>

#include <map>

#include "io/sha256.h"
#include "running_service.h"

namespace probebake {
namespace {

using test::RunningService;
/// SHA-256 by name: a difference is to be told in a line.
using Files = std::map<std::string, std::string>;

Json request() {
    Json request = test::net_request(4, 16);
    request["quality"]["targets"] = {{"psnr_db", 30.0}};
    request["products"] = {"cube", "aux", "latlong", "gl_faces", "sh"};
    request["lighting_states"] = {"albedo", "emission"};
    return request;
}

Files without_http() {
    const test::TempFolder folder;
    test::write_scenes(folder.path());
    const SceneFile file = *SceneLibrary(folder.path()).find("net");
    const JobSpec job = read_job(request());
    RenderPool pool(1);
    const CancelToken cancel;
    Files files;
    run_bake(
        {.job = job,
         .scene =
             [&](const CancelToken&) { return std::make_shared<const Scene>(load_scene(file)); },
         .pool = pool,
         .cancel = cancel,
         .sink =
             [&](const ProbeSpec& probe, const ProbeResult& result) {
                 for (const ProductFile& product : result.files) {
                     files[probe.id + "/" + std::string(name_of(result.state)) + "/" +
                           product.name] = sha256_hex(product.bytes);
                 }
             }});
    return files;
}

Files over_http(const RunningService& service) {
    const std::string id = service.bake(request());
    Files files;
    const std::string path = "/v1/bakes/" + id + "/probes";
    const Json page = service.get(path).json();
    for (const Json& row : page.at("rows")) {
        for (const Json& file : row.at("files")) {
            const std::string name = "/" + row.at("probe").get<std::string>() + "/" +
                                     row.at("state").get<std::string>() + "/" +
                                     file.at("name").get<std::string>();
            const std::string body = service.get(path + name).body;
            files[name.substr(1)] = sha256_hex(std::as_bytes(std::span(body)));
        }
    }
    return files;
}

TEST(ServiceDeterminism, TheSameBytesOnAnyNumberOfThreads) {
    const Files expected = without_http();
    ASSERT_EQ(expected.size(), 4U * 2 * 10);
    for (const int threads : {1, 2, 7}) {
        RunningService service([&](ServiceOptions& options) { options.threads = threads; });
        EXPECT_EQ(over_http(service), expected) << threads << " threads";
        // Beside another job, too, and once the service has started anew.
        const std::string other = service.submit(test::costly_request(500, 8));
        EXPECT_EQ(over_http(service), expected) << threads << " threads, not alone";
        service.restart();
        EXPECT_EQ(over_http(service), expected) << threads << " threads, after a restart";
    }
}

TEST(ServiceDeterminism, ARestartForgetsJobsAndTheirFiles) {
    RunningService service;
    const std::string id = service.bake(test::net_request(1));
    const std::filesystem::path files = service.options().data / "jobs" / id;
    EXPECT_TRUE(std::filesystem::exists(files));
    service.restart();
    EXPECT_EQ(service.get("/v1/bakes/" + id).status, 404);
    EXPECT_FALSE(std::filesystem::exists(files));
}

}  // namespace
}  // namespace probebake
