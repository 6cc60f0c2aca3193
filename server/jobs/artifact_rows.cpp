// The rows of a job: a file of lines, written once and read in pages.
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "io/io_error.h"
#include "jobs/artifact_store.h"

namespace probebake {
namespace {

constexpr const char* kRowFile = "probes.jsonl";

}  // namespace

ArtifactStore::RowWriter::RowWriter(const ArtifactStore& store, const std::string& job)
    : path_(store.folder_of(job) / kRowFile),
      temporary_(path_.string() + ".tmp"),
      file_(std::fopen(temporary_.c_str(), "we")) {
    if (file_ == nullptr) fail();
}

ArtifactStore::RowWriter::~RowWriter() {
    if (file_ == nullptr) return;
    std::fclose(file_);
    ::unlink(temporary_.c_str());
}

void ArtifactStore::RowWriter::fail() const {
    throw IoError(kRowFile, std::string("cannot be written: ") + std::strerror(errno));
}

void ArtifactStore::RowWriter::add(const Json& row) {
    const std::string line = dump_json(row) + "\n";
    if (std::fwrite(line.data(), 1, line.size(), file_) != line.size()) fail();
}

void ArtifactStore::RowWriter::commit() {
    if (std::fflush(file_) != 0 || ::fsync(::fileno(file_)) != 0) fail();
    if (std::rename(temporary_.c_str(), path_.c_str()) != 0) fail();
    std::fclose(file_);
    file_ = nullptr;
}

std::optional<RowPage> ArtifactStore::rows(const std::string& job, uint64_t offset,
                                           size_t count) const {
    const auto file = OpenFile::open(folder_of(job) / kRowFile);
    if (!file || offset > file->size_bytes()) return std::nullopt;
    if (offset > 0) {
        char before = 0;
        file->read_at(offset - 1, {&before, 1});
        if (before != '\n') return std::nullopt;
    }
    RowPage page;
    std::string line;
    std::array<char, 16384> buffer{};
    uint64_t at = offset;
    while (page.rows.size() < count) {
        const size_t n = file->read_at(at, buffer);
        if (n == 0) break;
        for (size_t i = 0; i < n && page.rows.size() < count; ++i) {
            ++at;
            if (buffer[i] != '\n') {
                line += buffer[i];
            } else {
                page.rows.push_back(std::move(line));
                line.clear();
            }
        }
    }
    if (at < file->size_bytes()) page.next = at;
    return page;
}

}  // namespace probebake
