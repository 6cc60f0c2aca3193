#include "store/file_store.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "io/sha256.h"
#include "store/sqlite.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;

constexpr size_t kChunkBytes = size_t{256} << 10;

[[noreturn]] void fail(const std::string& doing) {
    const int error = errno;
    if (error == ENOSPC || error == EDQUOT) throw DiskFull("files", "the disk is full");
    throw IoError("files", doing + ": " + std::strerror(error));
}

fs::path temporary_path(const DataFolder& data) {
    static std::atomic<uint64_t> counter{0};
    return data.temporary() / std::to_string(counter++);
}

}  // namespace

FileStore::Pin::Pin(FileStore& store, std::vector<std::string> digests)
    : store_(store), digests_(std::move(digests)) {
    const std::lock_guard lock(store_.mutex_);
    store_.pinned_.insert(digests_.begin(), digests_.end());
}

FileStore::Pin::~Pin() {
    const std::lock_guard lock(store_.mutex_);
    for (const std::string& digest : digests_) {
        store_.pinned_.erase(store_.pinned_.find(digest));
    }
}

fs::path FileStore::path_of(const std::string& digest) const {
    return data_.files() / digest.substr(0, 2) / digest;
}

void FileStore::put(const std::string& digest, std::span<const std::byte> bytes) {
    TemporaryFile file(data_);
    file.write(bytes);
    file.sync();
    adopt(digest, file.path());
}

void FileStore::adopt(const std::string& digest, const fs::path& temporary) {
    const fs::path path = path_of(digest);
    if (::rename(temporary.c_str(), path.c_str()) != 0) fail("a file cannot be renamed into place");
    sync_folder(path.parent_path());
}

std::shared_ptr<const OpenFile> FileStore::open(const std::string& digest) const {
    return OpenFile::open(path_of(digest));
}

void FileStore::remove(const std::string& digest,
                       const std::function<bool(const std::string&)>& named) {
    const std::lock_guard lock(mutex_);
    if (pinned_.contains(digest) || named(digest)) return;
    ::unlink(path_of(digest).c_str());
}

void FileStore::sweep(int folder, const std::function<bool(const std::string&)>& named) {
    constexpr const char* kDigits = "0123456789abcdef";
    const fs::path path = data_.files() / std::string{kDigits[folder / 16], kDigits[folder % 16]};
    std::error_code error;
    for (fs::directory_iterator at(path, error), end; !error && at != end; at.increment(error)) {
        remove(at->path().filename().string(), named);
    }
}

TemporaryFile::TemporaryFile(const DataFolder& data)
    : path_(temporary_path(data)),
      file_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)) {
    if (file_.get() < 0) fail("a file cannot be created");
}

TemporaryFile::~TemporaryFile() { ::unlink(path_.c_str()); }

void TemporaryFile::write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(file_.get(), bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail("a file cannot be written");
        bytes = bytes.subspan(static_cast<size_t>(n));
    }
}

void TemporaryFile::sync() {
    if (::fsync(file_.get()) != 0) {
        fail_stop(std::string("files: cannot be made durable: ") + std::strerror(errno));
    }
}

bool is_whole(const OpenFile& file, const std::string& digest) {
    Sha256 sha;
    std::vector<char> buffer(std::min<uint64_t>(kChunkBytes, file.size_bytes()));
    for (uint64_t at = 0; at < file.size_bytes();) {
        const size_t n = file.read_at(at, buffer);
        sha.update(std::as_bytes(std::span(buffer).first(n)));
        at += n;
    }
    return sha.hex() == digest;
}

}  // namespace probebake
