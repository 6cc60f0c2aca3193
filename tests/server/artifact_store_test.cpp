#include "jobs/artifact_store.h"

#include <gtest/gtest.h>

#include "io/io_error.h"
#include "io/sha256.h"
#include "jobs/job.h"
#include "temp_folder.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

ProbeResult result_with(const std::vector<std::pair<std::string, std::string>>& files) {
    ProbeResult result;
    for (const auto& [name, text] : files) {
        const auto bytes = std::as_bytes(std::span(text));
        result.files.push_back(
            {name, {bytes.begin(), bytes.end()}, bytes.size(), sha256_hex(bytes)});
    }
    return result;
}

std::string text_of(const OpenFile& file) {
    std::string text(file.size_bytes(), '\0');
    EXPECT_EQ(file.read_at(0, text), text.size());
    return text;
}

std::string problem_of_opening(const fs::path& folder) {
    try {
        const ArtifactStore store(folder);
    } catch (const IoError& error) {
        return error.what();
    }
    return "none";
}

TEST(ArtifactStore, KeepsWhatWasPublishedAndNothingElse) {
    const TempFolder folder;
    ArtifactStore store(folder.path());
    const std::string job = new_job_id();
    store.add_job(job);
    store.publish(job, "p.0", result_with({{"cube.exr", "abc"}, {"aux.exr", "defg"}}));

    const auto found = store.open(job, "p.0", "albedo", "aux.exr");
    ASSERT_TRUE(found);
    EXPECT_EQ(text_of(*found->content), "defg");
    EXPECT_EQ(found->file.size_bytes, 4U);
    EXPECT_EQ(found->file.sha256, sha256_hex(std::as_bytes(std::span("defg", 4))));
    EXPECT_EQ(test::read_text(folder.path() / "jobs" / job / "probes/p.0/albedo/cube.exr"), "abc");
    EXPECT_EQ(store.bytes_of(job), 2 * 4096U);

    test::write_text(folder.path() / "jobs" / job / "probes/p.0/albedo/secret", "x");
    for (const auto& [probe, state, name] :
         std::vector<std::array<std::string, 3>>{{"p.0", "albedo", "secret"},
                                                 {"p.0", "emission", "cube.exr"},
                                                 {"p.1", "albedo", "cube.exr"},
                                                 {"..", "p.0/albedo", "cube.exr"},
                                                 {"p.0", "albedo", "../../../../lock"},
                                                 {"p.0/albedo", "", "cube.exr"},
                                                 {"", "", ""}}) {
        EXPECT_FALSE(store.open(job, probe, state, name)) << probe << state << name;
    }
    EXPECT_FALSE(store.open("..", "p.0", "albedo", "cube.exr"));
}

TEST(ArtifactStore, UnitsComeInTheOrderOfPublication) {
    const TempFolder folder;
    ArtifactStore store(folder.path());
    const std::string job = new_job_id();
    store.add_job(job);
    for (const char* probe : {"c", "a", "b"}) {
        store.publish(job, probe, result_with({{"cube.exr", probe}}));
    }
    EXPECT_EQ(store.unit_count(job), 3U);
    const std::vector<StoredUnit> units = store.units(job, 1, 5);
    ASSERT_EQ(units.size(), 2U);
    EXPECT_EQ(units[0].probe, "a");
    EXPECT_EQ(units[1].probe, "b");
    EXPECT_TRUE(store.units(job, 3, 5).empty());
    EXPECT_TRUE(store.units(job, ~size_t{0}, 5).empty());
    EXPECT_TRUE(store.units(new_job_id(), 0, 5).empty());
}

TEST(ArtifactStore, DownloadsGoOnWhenTheJobIsForgotten) {
    const TempFolder folder;
    ArtifactStore store(folder.path());
    const std::string job = new_job_id();
    store.add_job(job);
    store.publish(job, "p", result_with({{"cube.exr", "abc"}}));
    const auto found = store.open(job, "p", "albedo", "cube.exr");
    store.remove_job(job);
    EXPECT_EQ(text_of(*found->content), "abc");
    EXPECT_FALSE(store.open(job, "p", "albedo", "cube.exr"));
    EXPECT_FALSE(fs::exists(folder.path() / "jobs" / job));
}

TEST(ArtifactStore, ADamagedFileIsNotServed) {
    const TempFolder folder;
    ArtifactStore store(folder.path());
    const std::string job = new_job_id();
    store.add_job(job);
    store.publish(job, "p", result_with({{"cube.exr", "abc"}}));
    test::write_text(folder.path() / "jobs" / job / "probes/p/albedo/cube.exr", "ab");
    EXPECT_THROW(store.open(job, "p", "albedo", "cube.exr"), IoError);
}

TEST(ArtifactStore, RowsComeInPages) {
    const TempFolder folder;
    ArtifactStore store(folder.path());
    const std::string job = new_job_id();
    store.add_job(job);
    EXPECT_FALSE(store.rows(job, 0, 10));
    {
        ArtifactStore::RowWriter writer(store, job);
        // Rows longer than what is read at once, too.
        for (int i = 0; i < 25; ++i) {
            writer.add({{"i", i}, {"text", std::string(static_cast<size_t>(i) * 2000, 'x')}});
        }
        EXPECT_FALSE(store.rows(job, 0, 10)) << "rows are there before they are whole";
        writer.commit();
    }
    int next_row = 0;
    std::vector<size_t> pages;
    for (std::optional<uint64_t> at = 0; at;) {
        const auto page = store.rows(job, *at, 10);
        ASSERT_TRUE(page);
        for (const std::string& row : page->rows) EXPECT_EQ(parse_json(row)["i"], next_row++);
        pages.push_back(page->rows.size());
        at = page->next;
    }
    EXPECT_EQ(pages, (std::vector<size_t>{10, 10, 5}));

    EXPECT_FALSE(store.rows(job, 1, 10)) << "no row begins there";
    EXPECT_FALSE(store.rows(job, 1'000'000, 10));
    EXPECT_FALSE(store.rows(job, ~uint64_t{0}, 10));
}

TEST(ArtifactStore, RowsOfABrokenOffBakeLeaveNothing) {
    const TempFolder folder;
    ArtifactStore store(folder.path());
    const std::string job = new_job_id();
    store.add_job(job);
    {
        ArtifactStore::RowWriter writer(store, job);
        writer.add({{"i", 1}});
    }
    EXPECT_TRUE(fs::is_empty(folder.path() / "jobs" / job));
}

TEST(DataFolder, IsUsedByOneServiceOnly) {
    const TempFolder folder;
    {
        const ArtifactStore store(folder.path());
        EXPECT_EQ(problem_of_opening(folder.path()),
                  folder.path().string() + ": is the data directory of another running service");
    }
    EXPECT_EQ(problem_of_opening(folder.path()), "none");
}

TEST(DataFolder, RemovesOldJobsAndNothingElse) {
    const TempFolder folder;
    const TempFolder elsewhere;
    const fs::path jobs = folder.path() / "jobs";
    const std::string old = new_job_id();
    const std::string link = new_job_id();
    const std::string file = new_job_id();
    test::write_text(jobs / old / "probes/p/albedo/cube.exr", "x");
    test::write_text(jobs / "notes" / "mine.txt", "x");
    test::write_text(jobs / ("x" + old) / "mine.txt", "x");
    test::write_text(jobs / file, "x");
    test::write_text(folder.path() / old / "mine.txt", "x");
    test::write_text(elsewhere.path() / "mine.txt", "x");
    fs::create_directory_symlink(elsewhere.path(), jobs / link);
    const ArtifactStore store(folder.path());
    EXPECT_FALSE(fs::exists(jobs / old));
    EXPECT_TRUE(fs::exists(jobs / "notes/mine.txt"));
    EXPECT_TRUE(fs::exists(jobs / ("x" + old) / "mine.txt"));
    EXPECT_TRUE(fs::exists(jobs / file));
    EXPECT_TRUE(fs::exists(folder.path() / old / "mine.txt"));
    EXPECT_TRUE(fs::exists(jobs / link / "mine.txt"));
}

TEST(DataFolder, AnUnusableOneIsRefusedInOneLine) {
    const TempFolder folder;
    test::write_text(folder.path() / "file", "x");
    const std::string problem = problem_of_opening(folder.path() / "file");
    EXPECT_NE(problem, "none");
    EXPECT_EQ(problem.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace probebake
