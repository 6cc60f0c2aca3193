#include "store/data_folder.h"

#include <sqlite3.h>

#include <fstream>

#include "store_fixture.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using DataFolderTest = test::StoreTest;

std::string problem_of_opening(const fs::path& folder) {
    try {
        const JobStore store(folder, {});
    } catch (const IoError& error) {
        return error.what();
    }
    return "none";
}

void run_sql(const fs::path& file, const char* sql) {
    sqlite3* db = nullptr;
    ASSERT_EQ(::sqlite3_open(file.c_str(), &db), SQLITE_OK);
    EXPECT_EQ(::sqlite3_exec(db, sql, nullptr, nullptr, nullptr), SQLITE_OK);
    ::sqlite3_close(db);
}

TEST_F(DataFolderTest, IsUsedByOneServiceOnly) {
    EXPECT_EQ(problem_of_opening(data()),
              data().string() + ": is the data directory of another running service");
    store_.reset();
    EXPECT_EQ(problem_of_opening(data()), "none");
}

TEST_F(DataFolderTest, LeavesAloneWhatIsNotItsOwn) {
    store_.reset();
    test::write_text(data() / "notes/mine.txt", "x");
    test::write_text(data() / "jobs/b-0/mine.txt", "x");
    open();
    while (store_->tidy()) {
    }
    EXPECT_TRUE(fs::exists(data() / "notes/mine.txt"));
    EXPECT_TRUE(fs::exists(data() / "jobs/b-0/mine.txt"));
}

TEST_F(DataFolderTest, UnusableOnesAreRefusedInOneLine) {
    store_.reset();
    test::write_text(folder_.path() / "file", "x");
    const fs::path damaged = folder_.path() / "damaged";
    test::write_text(damaged / "probebake.sqlite", std::string(8192, 'x'));
    const fs::path newer = folder_.path() / "newer";
    fs::create_directories(newer);
    run_sql(newer / "probebake.sqlite", "PRAGMA user_version = 99");
    const fs::path taken = folder_.path() / "taken";
    test::write_text(taken / "files", "x");
    const fs::path link = folder_.path() / "link";
    fs::create_directories(link);
    fs::create_symlink(data() / "probebake.sqlite", link / "probebake.sqlite");
    for (const auto& [folder, expected] : std::vector<std::pair<fs::path, std::string>>{
             {folder_.path() / "file", "cannot be used for data"},
             {folder_.path() / "file" / "below", "cannot be used for data"},
             {taken, "cannot be used for data"},
             {damaged, "probebake.sqlite: cannot be relied on"},
             {newer, "written by a newer service"},
             {link, "probebake.sqlite: cannot be opened"},
             {"/proc/self/nothing", "cannot be used for data"}}) {
        const std::string problem = problem_of_opening(folder);
        EXPECT_NE(problem.find(expected), std::string::npos) << folder << problem;
        EXPECT_EQ(problem.find('\n'), std::string::npos);
    }
}

TEST_F(DataFolderTest, ADamagedPageIsFoundAtStart) {
    for (int i = 0; i < 200; ++i) insert();
    store_.reset();
    const fs::path file = data() / "probebake.sqlite";
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekp(std::streamoff{3} * 4096);
    bytes.write(std::string(64, '\x7f').data(), 64);
    bytes.close();
    const std::string problem = problem_of_opening(data());
    EXPECT_NE(problem.find("probebake.sqlite"), std::string::npos) << problem;
}

TEST_F(DataFolderTest, TheSchemaHasAVersionAndIsStrict) {
    store_.reset();
    sqlite3* db = nullptr;
    ASSERT_EQ(::sqlite3_open((data() / "probebake.sqlite").c_str(), &db), SQLITE_OK);
    const auto number = [&](const char* sql) {
        sqlite3_stmt* statement = nullptr;
        EXPECT_EQ(::sqlite3_prepare_v2(db, sql, -1, &statement, nullptr), SQLITE_OK);
        EXPECT_EQ(::sqlite3_step(statement), SQLITE_ROW);
        const int value = ::sqlite3_column_int(statement, 0);
        ::sqlite3_finalize(statement);
        return value;
    };
    EXPECT_EQ(number("PRAGMA user_version"), 2);
    EXPECT_EQ(number("SELECT count(*) FROM pragma_table_list WHERE schema = 'main' AND type = "
                     "'table' AND name NOT LIKE 'sqlite%' AND strict = 0"),
              0);
    ::sqlite3_close(db);
}

TEST_F(DataFolderTest, ADatabaseOfAnEarlierVersionIsBroughtToThisOne) {
    const int64_t job = running();
    publish(job, 0, "abc");
    store_.reset();
    run_sql(data() / "probebake.sqlite",
            "ALTER TABLE jobs DROP COLUMN most_bytes; DROP TABLE expired; PRAGMA user_version = 1");
    open();
    EXPECT_EQ(find(job).units_done, 1U);
    EXPECT_EQ(find(job).most_bytes, 0U);
    EXPECT_TRUE(store_->open_unit_file(job, "p0", "albedo", "cube.exr")->content);
    const std::string id = find(job).id;
    end(job);
    store_->expire(job);
    EXPECT_EQ(store_->tenant_of_expired(id), "local");
}

TEST_F(DataFolderTest, TheBallastIsGivenUpAndComesBack) {
    const DataFolder& folder = store_->data();
    EXPECT_EQ(fs::file_size(data() / "ballast"), DataFolder::kBallastBytes);
    EXPECT_TRUE(folder.drop_ballast());
    EXPECT_FALSE(folder.drop_ballast());
    while (store_->tidy()) {
    }
    EXPECT_TRUE(fs::exists(data() / "ballast"));
}

}  // namespace
}  // namespace probebake
