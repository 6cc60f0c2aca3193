// C2 and C3: the power is cut at any moment; and in which order things reach the disk.
#include "power_cut.h"

#include <set>

#include "crash_fixture.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;
using test::DiskModel;
using test::DiskOp;
using test::TempFolder;

class PowerCutTest : public testing::Test {
  protected:
    void SetUp() override {
        if (test::sanitized()) GTEST_SKIP() << "the shim and a sanitizer do not go together";
        const std::string log = (folder_.path() / "log").string();
        const std::string ack = (folder_.path() / "ack").string();
        test::Process workload(
            folder_.path() / "workload", {root_, ack, "60"},
            test::shimmed(PROBEBAKE_WORKLOAD,
                          {"SHIM_ROOT=" + root_, "SHIM_LOG=" + log, "SHIM_ACK=" + ack}));
        ASSERT_EQ(workload.wait(), 0) << workload.err();
        for (DiskOp& op : test::read_disk_log(test::read_text(log))) {
            // Neither holds anything that was promised.
            if (op.path.find("/ballast") != std::string::npos) continue;
            if (op.path.find("/lock") != std::string::npos) continue;
            log_.push_back(std::move(op));
        }
        ASSERT_GT(log_.size(), 1000U);
    }

    struct Outcome {
        int cuts = 0;
        int broken = 0;
        int unusable = 0;
    };
    /// Cuts the power `count` times at random places of a log, after the store was there.
    Outcome cut(const std::vector<DiskOp>& log, int count) {
        std::mt19937_64 random(7);
        size_t begin = 0;
        while (log[begin].kind != DiskOp::kAck) ++begin;
        std::multiset<size_t> places;
        for (int i = 0; i < count; ++i) {
            places.insert(begin + random() % (log.size() - begin));
        }
        Outcome outcome;
        DiskModel disk(root_);
        size_t at = 0;
        const fs::path memory = fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
        for (const size_t place : places) {
            for (; at <= place; ++at) disk.apply(log[at]);
            const fs::path data = memory / ("probebake-cut-" + std::to_string(::getpid()));
            fs::remove_all(data);
            fs::create_directories(data);
            disk.cut(data, random);
            const int verdict = test::check_store(data, disk.promises(), outcome.broken < 3);
            fs::remove_all(data);
            ++outcome.cuts;
            if (verdict == test::kBroken) ++outcome.broken;
            if (verdict != test::kBroken && verdict != test::kKept) ++outcome.unusable;
        }
        std::cout << outcome.cuts << " cuts: " << outcome.broken << " broke a promise, "
                  << outcome.unusable << " left an unusable store\n";
        return outcome;
    }

    TempFolder folder_;
    const std::string root_ = (folder_.path() / "data").string();
    std::vector<DiskOp> log_;
};

TEST_F(PowerCutTest, NothingThatWasPromisedIsLost) {
    const Outcome outcome = cut(log_, test::form("PROBEBAKE_CUTS", 300));
    EXPECT_EQ(outcome.broken, 0);
    EXPECT_EQ(outcome.unusable, 0);
}

TEST_F(PowerCutTest, CommitsThatAreNotSyncedAreFoundOut) {
    std::vector<DiskOp> mutant;
    for (const DiskOp& op : log_) {
        if (op.kind == DiskOp::kSync && op.path.ends_with("-wal")) continue;
        mutant.push_back(op);
    }
    ASSERT_LT(mutant.size(), log_.size());
    EXPECT_GT(cut(mutant, 100).broken, 20);
}

TEST_F(PowerCutTest, FoldersThatAreNotSyncedAreFoundOut) {
    std::vector<DiskOp> mutant;
    DiskModel disk(root_);
    for (const DiskOp& op : log_) {
        disk.apply(op);
        if (op.kind == DiskOp::kSync && !disk.is_file(op.path)) continue;
        mutant.push_back(op);
    }
    const Outcome outcome = cut(mutant, 100);
    EXPECT_GT(outcome.broken + outcome.unusable, 20);
}

TEST_F(PowerCutTest, FilesThatComeAfterTheirRowsAreFoundOut) {
    std::vector<DiskOp> mutant;
    std::vector<DiskOp> held;
    for (const DiskOp& op : log_) {
        const bool file = op.path.find("/temporary/") != std::string::npos ||
                          op.path.find("/files/") != std::string::npos;
        if (file && op.kind != DiskOp::kMakeFolder) {
            held.push_back(op);
            continue;
        }
        mutant.push_back(op);
        if (op.kind == DiskOp::kSync && op.path.ends_with("-wal")) {
            mutant.insert(mutant.end(), held.begin(), held.end());
            held.clear();
        }
    }
    EXPECT_GT(cut(mutant, 200).broken, 5);
}

// C3: when a promise is made, nothing that it stands on waits for the disk; and a row is written
// when its file is durable.
TEST_F(PowerCutTest, ThingsReachTheDiskInTheirOrder) {
    std::set<std::string> dirty;  // files with unsynced bytes, folders with unsynced names
    const auto folder_of = [](const std::string& path) { return path.substr(0, path.rfind('/')); };
    const auto files_are_dirty = [&] {
        return std::any_of(dirty.begin(), dirty.end(), [](const std::string& path) {
            return path.find("/files/") != std::string::npos;
        });
    };
    size_t promises = 0;
    for (const DiskOp& op : log_) {
        const bool in_temporary = op.path.find("/temporary/") != std::string::npos;
        switch (op.kind) {
            case DiskOp::kWrite:
            case DiskOp::kTruncate:
                if (op.path.ends_with("-wal")) {
                    EXPECT_FALSE(files_are_dirty()) << "a row before its file";
                }
                dirty.insert(op.path);
                break;
            case DiskOp::kSync:
                dirty.erase(op.path);
                break;
            case DiskOp::kRename:
                EXPECT_EQ(dirty.count(op.path), 0U) << "renamed before its bytes were durable";
                dirty.insert(folder_of(op.to));
                break;
            case DiskOp::kCreate:
                if (!in_temporary) dirty.insert(folder_of(op.path));
                break;
            case DiskOp::kAck:
                ++promises;
                for (const std::string& path : dirty) {
                    // A checkpoint may leave the database itself behind its log, and the log holds
                    // it all; names that go are repeated by the next start.
                    EXPECT_TRUE(path.ends_with("probebake.sqlite")) << op.data << path;
                }
                break;
            case DiskOp::kUnlink:
            case DiskOp::kMakeFolder:
                break;
        }
    }
    EXPECT_GT(promises, 100U);
}

}  // namespace
}  // namespace probebake
