// Scenes that clients bring: taken whole, with the right digest, or refused with the reason.
#include <archive.h>
#include <archive_entry.h>
#include <gtest/gtest.h>

#include "http/file_answer.h"
#include "io/file.h"
#include "io/sha256.h"
#include "raw_client.h"
#include "running_service.h"
#include "scene/vox_seeds.h"

namespace probebake {
namespace {

using test::Answer;
using test::RunningService;

struct Entry {
    std::string name;
    std::string content;
    unsigned type = AE_IFREG;
};

std::string tar_of(const std::vector<Entry>& entries) {
    std::string bytes(size_t{1} << 20, '\0');
    size_t used = 0;
    archive* const tar = ::archive_write_new();
    ::archive_write_set_format_pax_restricted(tar);
    ::archive_write_open_memory(tar, bytes.data(), bytes.size(), &used);
    for (const Entry& file : entries) {
        archive_entry* const entry = ::archive_entry_new();
        ::archive_entry_set_pathname(entry, file.name.c_str());
        ::archive_entry_set_filetype(entry, file.type);
        ::archive_entry_set_perm(entry, 0644);
        if (file.type == AE_IFLNK) ::archive_entry_set_symlink(entry, file.content.c_str());
        const bool plain = file.type == AE_IFREG;
        ::archive_entry_set_size(entry, plain ? static_cast<la_int64_t>(file.content.size()) : 0);
        EXPECT_EQ(::archive_write_header(tar, entry), ARCHIVE_OK);
        if (plain) ::archive_write_data(tar, file.content.data(), file.content.size());
        ::archive_entry_free(entry);
    }
    ::archive_write_free(tar);
    bytes.resize(used);
    return bytes;
}

constexpr const char* kSceneJson = R"({"type": "vox", "file": "model.vox", "voxel_size_m": 0.5})";

std::string vox() {
    const test::Bytes bytes = test::every_chunk().file();
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string whole_scene() {
    return tar_of({{"./", "", AE_IFDIR}, {"./scene.json", kSceneJson}, {"model.vox", vox()}});
}

class SceneUploadTest : public testing::Test {
  protected:
    static void allow(ServiceOptions& options) {
        options.http.guard.max_upload_bytes = uint64_t{1} << 20;
        options.cache.importer = ImportProcess{.program = PROBEBAKE_BINARY,
                                               .scratch = options.data / "temporary",
                                               .limits = {.time = std::chrono::seconds(60)}};
    }
    Answer put(const std::string& name, const std::string& body,
               const std::optional<std::string>& digest = std::nullopt,
               const char* type = "application/x-tar") const {
        const std::string own = repr_digest(sha256_hex(std::as_bytes(std::span(body))));
        httplib::Headers headers = {{"Repr-Digest", digest.value_or(own)}};
        if (digest && digest->empty()) headers.clear();
        return service_.put("/v1/scenes/" + name, headers, body, type);
    }
    std::string refusal(const std::string& body) const {
        const Answer answer = put("castle", body);
        EXPECT_EQ(answer.status, 422) << answer.body;
        return answer.status == 422 ? answer.json().at("errors").at(0).at("detail") : "";
    }
    bool is_there(const std::string& name) const {
        return service_.get("/v1/scenes/" + name).status == 200;
    }
    size_t temporary_files() const {
        const std::filesystem::directory_iterator all(service_.options().data / "temporary");
        return static_cast<size_t>(std::distance(begin(all), end(all)));
    }

    RunningService service_{&SceneUploadTest::allow};
};

TEST_F(SceneUploadTest, IsBakedReplacedAndRemoved) {
    const Answer taken = put("castle", whole_scene());
    ASSERT_EQ(taken.status, 201) << taken.body;
    EXPECT_EQ(taken.header("Location"), "/v1/scenes/castle");
    EXPECT_EQ(taken.json().at("uploaded"), true);
    EXPECT_EQ(temporary_files(), 0U);

    service_.restart();
    const Json shown = service_.get("/v1/scenes/castle").json();
    EXPECT_EQ(shown.at("type"), "vox");
    EXPECT_EQ(shown.at("sha256").get<std::string>().size(), 64U);
    service_.bake({{"scene", "castle"},
                   {"probes", {{"list", {{{"id", "p"}, {"position_m", {0.0, 1.0, 0.0}}}}}}}});

    const std::string other =
        tar_of({{"scene.json", R"({"type": "vox", "file": "model.vox", "voxel_size_m": 1})"},
                {"model.vox", vox()}});
    EXPECT_EQ(put("castle", other).status, 200);
    EXPECT_NE(service_.get("/v1/scenes/castle").json().at("sha256"), shown.at("sha256"));

    EXPECT_EQ(service_.remove("/v1/scenes/castle").status, 204);
    EXPECT_FALSE(is_there("castle"));
    EXPECT_EQ(service_.remove("/v1/scenes/castle").status, 404);
    EXPECT_EQ(temporary_files(), 0U);
}

TEST_F(SceneUploadTest, WhatDoesNotArriveAsItWasSentIsRefused) {
    const std::string body = whole_scene();
    EXPECT_EQ(put("castle", body, "").status, 400);
    EXPECT_EQ(put("castle", body, "sha-256=:AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA=:").status,
              422);
    EXPECT_EQ(put("castle", body, std::nullopt, "application/json").status, 415);
    EXPECT_EQ(put("castle", std::string((size_t{1} << 20) + 1, 'x')).status, 413);
    EXPECT_EQ(put("Castle", body).status, 404);
    EXPECT_FALSE(is_there("castle"));
    EXPECT_EQ(temporary_files(), 0U);
}

// The library finds a scene's path in these; the guard took them for requests of other limits.
TEST_F(SceneUploadTest, OnlyAPlainNameIsTaken) {
    const std::string body = whole_scene();
    for (const char* name : {"%63astle", "castle%2Fb", "castle?"}) {
        EXPECT_EQ(put(name, body, std::nullopt, "application/json").status, 404) << name;
    }
    EXPECT_FALSE(is_there("castle"));
    EXPECT_EQ(temporary_files(), 0U);
}

TEST_F(SceneUploadTest, AnImportDoesNotHoldUpTheEnd) {
    const test::TempFolder folder;
    const std::filesystem::path importer = folder.path() / "importer";
    test::write_text(importer, "#!/bin/sh\ntouch \"$0.runs\"\nexec sleep 600\n");
    std::filesystem::permissions(importer, std::filesystem::perms::owner_all);
    RunningService service([&](ServiceOptions& options) {
        allow(options);
        options.cache.importer->program = importer;
    });
    const std::string body = whole_scene();
    const std::string head =
        "PUT /v1/scenes/castle HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/x-tar\r\n"
        "Repr-Digest: " +
        repr_digest(sha256_hex(std::as_bytes(std::span(body)))) +
        "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n";
    test::RawClient client(service.port());
    ASSERT_TRUE(client.send(head + body));
    for (int i = 0; i < 2000 && !std::filesystem::exists(importer.string() + ".runs"); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(std::filesystem::exists(importer.string() + ".runs"));
    EXPECT_LT(test::seconds_of([&] {
                  (*service).drain(std::chrono::milliseconds(100));
                  service.stop();
              }),
              test::patient(5.0));
}

TEST_F(SceneUploadTest, TheLibrarysOwnScenesStay) {
    const std::string own = service_.get("/v1/scenes").json().at("scenes").at(0).at("name");
    EXPECT_EQ(put(own, whole_scene()).status, 409);
    EXPECT_EQ(service_.remove("/v1/scenes/" + own).status, 409);
    EXPECT_TRUE(is_there(own));
}

TEST_F(SceneUploadTest, HostileArchivesAreRefusedWithTheReason) {
    const Entry scene{"scene.json", kSceneJson};
    const Entry model{"model.vox", vox()};
    EXPECT_NE(refusal(std::string(2000, 'x')).find("tar"), std::string::npos);
    EXPECT_NE(refusal(tar_of({model})).find("scene.json"), std::string::npos);
    for (const char* name : {"../model.vox", "/etc/model.vox", "a/../../model.vox", ".hidden",
                             "a//b", "a/b/c/d/e/model.vox"}) {
        EXPECT_NE(refusal(tar_of({scene, {name, vox()}})).find("plain files"), std::string::npos);
    }
    EXPECT_NE(refusal(tar_of({scene, {"model.vox", "/etc/passwd", AE_IFLNK}})).find("plain files"),
              std::string::npos);
    EXPECT_NE(refusal(tar_of({scene, model, model})).find("twice"), std::string::npos);
    EXPECT_NE(refusal(tar_of({scene, model, {"other.json", "{}"}})).find(".json"),
              std::string::npos);
    EXPECT_NE(refusal(tar_of({scene})).find("model.vox"), std::string::npos);
    EXPECT_NE(refusal(tar_of({scene, {"model.vox", vox().substr(0, 100)}})).find("model.vox"),
              std::string::npos);
    EXPECT_NE(refusal(tar_of({{"scene.json", R"({"type": "generator", "generator": "box"})"}}))
                  .find("generated"),
              std::string::npos);
    const std::string whole = whole_scene();
    EXPECT_NE(refusal(whole.substr(0, 3000)), "");
    EXPECT_FALSE(is_there("castle"));
    EXPECT_EQ(temporary_files(), 0U);
}

TEST(SceneUploads, AreOffByDefault) {
    const RunningService service;
    EXPECT_EQ(service.put("/v1/scenes/castle", {}, "x", "application/x-tar").status, 403);
    EXPECT_EQ(service.get("/v1/limits").json().at("upload_bytes"), 0);
}

}  // namespace
}  // namespace probebake
