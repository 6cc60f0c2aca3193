#include "jobs/scene_uploads.h"

#include <fcntl.h>
#include <cstdio>  // renameat2, RENAME_EXCHANGE
#include <utility>

#include "io/io_error.h"
#include "store/job_state.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;

/// A folder beneath `temporary` that is gone in the end, whatever stands in it then.
class Staging {
  public:
    explicit Staging(const DataFolder& data) : path_(data.temporary() / new_job_id()) {
        fs::create_directories(path_ / "scene");
        fs::create_directories(path_ / "cache");
    }
    ~Staging() {
        std::error_code error;
        fs::remove_all(path_, error);
    }
    Staging(const Staging&) = delete;
    Staging& operator=(const Staging&) = delete;
    fs::path scene() const { return path_ / "scene"; }
    fs::path cache() const { return path_ / "cache"; }

  private:
    fs::path path_;
};

/// Makes the names in a folder and in all folders beneath it durable.
void sync_folders(const fs::path& top) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(top)) {
        if (entry.is_directory()) sync_folder(entry.path());
    }
    sync_folder(top);
}

}  // namespace

SceneUploads::SceneUploads(const DataFolder& data, std::optional<ImportProcess> importer,
                           std::optional<fs::path> cache_dir)
    : data_(data), importer_(std::move(importer)), cache_dir_(std::move(cache_dir)) {}

bool SceneUploads::put(const std::string& name, const fs::path& archive,
                       const CancelToken& cancel) {
    if (!importer_) throw IoError(name, "there is no process to import it");
    const std::lock_guard lock(mutex_);
    const Staging staging(data_);
    import_archive_in_process(*importer_, archive, staging.scene() / (name + ".json"),
                              cache_dir_.value_or(staging.cache()), cancel);
    sync_folders(staging.scene());
    const fs::path place = data_.scenes() / name;
    const bool replaced = fs::exists(place);
    // What was there goes with the staging folder.
    if (::renameat2(AT_FDCWD, staging.scene().c_str(), AT_FDCWD, place.c_str(),
                    replaced ? RENAME_EXCHANGE : RENAME_NOREPLACE) != 0) {
        throw IoError(name, "cannot be put into place");
    }
    sync_folder(data_.scenes());
    return replaced;
}

bool SceneUploads::remove(const std::string& name) {
    const std::lock_guard lock(mutex_);
    if (!has(name)) return false;
    const Staging staging(data_);
    if (::rename((data_.scenes() / name).c_str(), (staging.scene() / name).c_str()) != 0) {
        throw IoError(name, "cannot be removed");
    }
    sync_folder(data_.scenes());
    return true;
}

bool SceneUploads::has(const std::string& name) const {
    std::error_code error;
    return fs::is_regular_file(data_.scenes() / name / (name + ".json"), error);
}

}  // namespace probebake
