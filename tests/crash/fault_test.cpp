// C4 and C9: the disk is full, fails or has no descriptor left, at every step.
#include <sstream>

#include "crash_fixture.h"

namespace probebake {
namespace {

using test::Process;
using test::TempFolder;

struct Fault {
    const char* kind;
    int operations;  // about as many as the workload has
};

struct Outcome {
    int code = 0;  // of the workload; -2: it does not end
    std::string said;
    int verdict = test::kKept;  // about what it left, without the fault
};

/// The workload in a folder of its own, its n-th operation of that kind failing.
Outcome run_with_fault(const std::string& kind, int n, int jobs) {
    const TempFolder folder;
    const std::string data = (folder.path() / "data").string();
    const std::string ack = (folder.path() / "ack").string();
    Process workload(
        folder.path() / "workload", {data, ack, std::to_string(jobs)},
        test::shimmed(PROBEBAKE_WORKLOAD,
                      {"SHIM_ROOT=" + data, "SHIM_FAIL=" + kind + ":" + std::to_string(n)}));
    const int code = workload.wait().value_or(-2);
    return {code, workload.err(),
            test::check_store(data, test::read_promises(test::read_text(ack)), true)};
}

class FaultTest : public testing::TestWithParam<Fault> {};

TEST_P(FaultTest, NothingThatWasPromisedIsLost) {
    if (test::sanitized()) GTEST_SKIP() << "the shim and a sanitizer do not go together";
    const std::string kind = GetParam().kind;
    // So many of the operations; as many as there are, or more: every one.
    const int wanted = test::form("PROBEBAKE_FAULTS", 25);
    const int step = std::max(1, GetParam().operations / std::max(1, wanted));
    int refused = 0;
    int ended = 0;
    int unharmed = 0;
    // Some operations may fail without harm; behind the last one none fails any more.
    const int enough = std::max(2, 32 / step);
    int in_a_row = 0;
    for (int n = 1; in_a_row < enough && n < 5000; n += step) {
        const auto [code, said, verdict] = run_with_fault(kind, n, 8);
        ASSERT_TRUE(code == 0 || code == 3 || code == 74) << "step " << n << ": " << code << said;
        if (code != 0) {
            EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
        }
        refused += code == 3 ? 1 : 0;
        ended += code == 74 ? 1 : 0;
        unharmed += code == 0 ? 1 : 0;
        in_a_row = code == 0 ? in_a_row + 1 : 0;
        EXPECT_EQ(verdict, test::kKept) << "step " << n;
    }
    std::cout << kind << ": " << refused << " times refused with an error, " << ended
              << " times ended to recover, " << unharmed << " times unharmed\n";
    EXPECT_GT(refused + ended, 3);
}

// The page that was not written counts as clean afterwards: a second fsync would succeed, and mean
// nothing.
TEST(FailedSync, C9_IsNeverTriedAgain) {
    if (test::sanitized()) GTEST_SKIP() << "the shim and a sanitizer do not go together";
    int ended = 0;
    int tried = 0;
    // The 4th and the 8th are SQLite's own of the folder, whose outcome it does not look at; the
    // 11th is ours of the same folder.
    for (const int n : {1, 2, 3, 5, 11, 13, 21, 34, 55, 89}) {
        const auto [code, said, verdict] = run_with_fault("fsync", n, 40);
        ++tried;
        ended += code == 74 ? 1 : 0;
        EXPECT_NE(code, 0) << "fsync " << n << " failed, and it went on";
        EXPECT_EQ(verdict, test::kKept) << "fsync " << n;
    }
    std::cout << ended << " of " << tried << " ended to recover\n";
    EXPECT_GE(ended, 7);
}

TEST(UnusableData, C5_NetworkFileSystemsAreRefused) {
    if (test::sanitized()) GTEST_SKIP() << "the shim and a sanitizer do not go together";
    const TempFolder folder;
    const auto start_on = [&](const std::string& type) {
        const std::string data = (folder.path() / type).string();
        Process workload(
            folder.path() / "workload", {data, (folder.path() / "ack").string(), "1"},
            test::shimmed(PROBEBAKE_WORKLOAD, {"SHIM_ROOT=" + data, "SHIM_FS_TYPE=" + type}));
        const int code = workload.wait().value_or(-2);
        return std::pair(code, workload.err());
    };
    for (const char* type : {"6969", "517b", "ff534d42", "fe534d42", "1021997", "65735546"}) {
        const auto [code, said] = start_on(type);
        EXPECT_EQ(code, 3) << type;
        EXPECT_NE(said.find("network file system"), std::string::npos) << said;
        EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    }
    EXPECT_EQ(start_on("ef53").first, 0) << "ext4";
}

INSTANTIATE_TEST_SUITE_P(Kinds, FaultTest,
                         testing::Values(Fault{"enospc", 600}, Fault{"eio", 1000},
                                         Fault{"emfile", 50}),
                         [](const auto& fault) { return std::string(fault.param.kind); });

}  // namespace
}  // namespace probebake
