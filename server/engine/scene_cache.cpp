#include "engine/scene_cache.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <system_error>
#include <utility>

#include "io/cache_folder.h"
#include "io/file_beneath.h"
#include "io/io_error.h"
#include "io/sha256.h"

namespace probebake {
namespace {

/// How often a waiting job looks whether it was cancelled.
constexpr std::chrono::milliseconds kCancelInterval{50};

/// The path of a file that nobody else uses, removed in the end if it was made.
class PassingFile {
  public:
    PassingFile(const std::filesystem::path& folder, const std::string& extension) {
        static std::atomic<uint64_t> count = 0;
        path_ = folder / (std::to_string(::getpid()) + "-" + std::to_string(count++) + extension);
    }
    ~PassingFile() {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    PassingFile(const PassingFile&) = delete;
    PassingFile& operator=(const PassingFile&) = delete;

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace

SceneCache::SceneCache(RenderPool& pool, Options options)
    : pool_(pool), options_(std::move(options)) {}

SceneCache::~SceneCache() {
    end_.cancel();
    std::list<Loader> loaders;  // joined here, without the lock that they need to finish
    const std::lock_guard lock(mutex_);
    loaders.swap(loaders_);
}

std::shared_ptr<const Scene> SceneCache::get(const SceneFile& file, const CancelToken& cancel) {
    const std::string key = content_sha256(file);
    std::unique_lock lock(mutex_);
    std::shared_ptr<Entry>& known = entries_[key];
    if (!known) {
        known = std::make_shared<Entry>();
        loaders_.push_back(
            {known, std::jthread([this, file, key, entry = known] { load(file, key, entry); })});
    }
    const std::shared_ptr<Entry> entry = known;
    while (entry->loading) {
        cancel.throw_if_cancelled();
        changed_.wait_for(lock, kCancelInterval);
    }
    join_loaders();
    if (entry->failure) std::rethrow_exception(entry->failure);
    entry->last_use = ++uses_;
    std::shared_ptr<const Scene> scene = entry->scene;
    evict();
    return scene;
}

void SceneCache::load(const SceneFile& file, const std::string& key,
                      const std::shared_ptr<Entry>& entry) {
    std::shared_ptr<const Scene> scene;
    std::exception_ptr failure;
    try {
        scene = load_or_throw(file);
    } catch (...) {
        failure = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    entry->scene = std::move(scene);
    entry->failure = std::move(failure);
    entry->last_use = ++uses_;
    entry->loading = false;
    if (entry->failure) entries_.erase(key);  // the next one who asks tries again
    changed_.notify_all();
}

std::shared_ptr<const Scene> SceneCache::load_or_throw(const SceneFile& file) {
    if (options_.tree_cache_dir) trim_cache(*options_.tree_cache_dir, options_.cache_bytes);
    std::optional<Scene> scene;
    if (!is_foreign(file) || !options_.importer) {
        pool_.run([&] { scene = load_scene(file, options_.tree_cache_dir); });
        return std::make_shared<const Scene>(std::move(*scene));
    }
    const std::filesystem::path folder =
        options_.tree_cache_dir.value_or(options_.importer->scratch);
    scene = find_cached_scene(file, folder);
    if (!scene) {
        import_in_process(*options_.importer, file, folder, end_);
        scene = find_cached_scene(file, folder);
        if (!scene) throw IoError(file.name, "was changed while it was imported");
        if (!options_.tree_cache_dir) remove_cached_scene(file, scene->sha256, folder);
    }
    scene->cache_dir = options_.tree_cache_dir;
    return std::make_shared<const Scene>(std::move(*scene));
}

SkyFile SceneCache::sky(const std::filesystem::path& picture, const CancelToken& cancel) const {
    if (!options_.importer) return read_sky_file(picture);
    if (!options_.tree_cache_dir) {
        const PassingFile decoded(options_.importer->scratch, ".sky");
        import_sky_in_process(*options_.importer, picture, decoded.path(), cancel);
        return load_sky(decoded.path());
    }
    const std::filesystem::path kept =
        *options_.tree_cache_dir /
        (sha256_hex(read_file_beneath(picture, kMaxSkyFileBytes)) + ".sky");
    try {
        SkyFile sky = load_sky(kept);
        mark_used(kept);
        return sky;
    } catch (const IoError&) {  // never made, damaged, or another job has just trimmed the cache
    }
    import_sky_in_process(*options_.importer, picture, kept, cancel);
    return load_sky(kept);
}

void SceneCache::evict() {
    while (loaded_bytes() > options_.memory_budget_bytes) {
        auto oldest = entries_.end();
        for (auto at = entries_.begin(); at != entries_.end(); ++at) {
            const Entry& entry = *at->second;
            const bool idle = entry.scene && entry.scene.use_count() == 1;  // no job holds it
            if (idle && (oldest == entries_.end() || entry.last_use < oldest->second->last_use)) {
                oldest = at;
            }
        }
        if (oldest == entries_.end()) return;  // all in use
        entries_.erase(oldest);
    }
}

void SceneCache::join_loaders() {
    loaders_.remove_if([](const Loader& loader) { return !loader.entry->loading; });
}

uint64_t SceneCache::memory_bytes() const {
    const std::lock_guard lock(mutex_);
    return loaded_bytes();
}

uint64_t SceneCache::loaded_bytes() const {
    uint64_t bytes = 0;
    for (const auto& [key, entry] : entries_) {
        if (entry->scene) bytes += entry->scene->memory_bytes();
    }
    return bytes;
}

}  // namespace probebake
