#include "engine/scene_archive.h"

#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <set>

#include "io/io_error.h"
#include "scene/scene_library.h"

namespace probebake {
namespace {

constexpr const char* kArchive = "archive";
constexpr const char* kSceneFile = "scene.json";
constexpr size_t kChunkBytes = size_t{1} << 18;
constexpr size_t kMaxFiles = 64;

struct Closes {
    void operator()(archive* tar) const { ::archive_read_free(tar); }
};
using Tar = std::unique_ptr<archive, Closes>;

[[noreturn]] void refuse(const std::string& name, const std::string& why) {
    throw IoError(kArchive, (name.empty() ? "" : "\"" + name.substr(0, 80) + "\": ") + why);
}

Tar open_tar(const std::filesystem::path& path) {
    Tar tar(::archive_read_new());
    ::archive_read_support_format_tar(tar.get());
    if (::archive_read_open_filename(tar.get(), path.c_str(), kChunkBytes) != ARCHIVE_OK) {
        refuse("", "is no uncompressed tar");
    }
    return tar;
}

/// A new file that is durable once it was closed.
class NewFileBeneath {
  public:
    explicit NewFileBeneath(const std::filesystem::path& path)
        : name_(path.filename().string()),
          fd_(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644)) {
        if (fd_ < 0) refuse(name_, std::strerror(errno));
    }
    ~NewFileBeneath() { ::close(fd_); }
    NewFileBeneath(const NewFileBeneath&) = delete;
    NewFileBeneath& operator=(const NewFileBeneath&) = delete;

    void write(const char* bytes, size_t size) {
        while (size > 0) {
            const ssize_t n = ::write(fd_, bytes, size);
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) refuse(name_, std::strerror(errno));
            bytes += n;
            size -= static_cast<size_t>(n);
        }
    }
    void sync() {
        if (::fsync(fd_) != 0) refuse(name_, std::strerror(errno));
    }

  private:
    std::string name_;
    int fd_;
};

/// Bytes of one entry, which the archive holds as they are.
void copy(archive* tar, uint64_t size_bytes, NewFileBeneath& file, const std::string& name) {
    std::string buffer(kChunkBytes, '\0');
    uint64_t left = size_bytes;
    while (left > 0) {
        const la_ssize_t n = ::archive_read_data(tar, buffer.data(), buffer.size());
        if (n <= 0) refuse(name, "is cut off");
        file.write(buffer.data(), static_cast<size_t>(n));
        left -= std::min<uint64_t>(left, static_cast<uint64_t>(n));
    }
}

/// Names of files, with folders before the last.
bool is_path(const std::string& text) {
    constexpr size_t kMaxFolders = 4;
    size_t folders = 0;
    std::string rest = text;
    if (!rest.empty() && rest.back() == '/') rest.pop_back();
    for (size_t slash = rest.find('/'); slash != std::string::npos; slash = rest.find('/')) {
        if (++folders > kMaxFolders || !is_file_name(rest.substr(0, slash))) return false;
        rest.erase(0, slash + 1);
    }
    return is_file_name(rest);
}

}  // namespace

void unpack_scene(const std::filesystem::path& archive, const std::filesystem::path& folder,
                  const std::string& name) {
    uint64_t left_bytes = std::filesystem::file_size(archive);
    const Tar tar = open_tar(archive);
    std::set<std::string> seen;
    for (;;) {
        archive_entry* entry = nullptr;
        const int code = ::archive_read_next_header(tar.get(), &entry);
        if (code == ARCHIVE_EOF) break;
        if (code != ARCHIVE_OK) refuse("", "is no uncompressed tar, or a damaged one");
        const char* const path = ::archive_entry_pathname(entry);
        std::string file = path == nullptr ? "" : path;
        if (file.rfind("./", 0) == 0) file.erase(0, 2);
        const bool own_folder = ::archive_entry_filetype(entry) == AE_IFDIR && file.empty();
        if (own_folder) continue;
        if (::archive_entry_filetype(entry) == AE_IFDIR && is_path(file)) continue;
        if (::archive_entry_filetype(entry) != AE_IFREG ||
            ::archive_entry_hardlink(entry) != nullptr || !is_path(file)) {
            refuse(file,
                   "expected plain files, at most four folders deep, whose names match "
                   "[A-Za-z0-9][A-Za-z0-9._-]{0,63}");
        }
        if (file != kSceneFile && std::filesystem::path(file).extension() == ".json") {
            refuse(file, "expected no further .json beside scene.json");
        }
        if (!seen.insert(file).second) refuse(file, "is there twice");
        if (seen.size() > kMaxFiles) refuse("", "holds more than 64 files");
        // A sparse file would become larger than what was sent.
        const auto size_bytes = static_cast<uint64_t>(std::max<la_int64_t>(
            0, ::archive_entry_size_is_set(entry) ? ::archive_entry_size(entry) : 0));
        if (size_bytes > left_bytes) refuse(file, "is larger than the archive");
        left_bytes -= size_bytes;
        const std::filesystem::path place = folder / (file == kSceneFile ? name + ".json" : file);
        std::filesystem::create_directories(place.parent_path());
        NewFileBeneath out(place);
        copy(tar.get(), size_bytes, out, file);
        out.sync();
    }
    if (!seen.contains(kSceneFile)) refuse("", "holds no scene.json");
}

}  // namespace probebake
