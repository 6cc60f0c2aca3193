// SceneCache: loaded scenes, shared by all jobs that bake in them.
//
// A scene is loaded once however many ask for it at the same time, on the render pool. Loaded
// scenes stay until the memory budget is exceeded; then those go first that no job holds and that
// were asked for longest ago. A job that is cancelled stops waiting at once; the load goes on for
// the others and for the cache.
#pragma once

#include <condition_variable>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "engine/render_pool.h"
#include "engine/scene_import.h"
#include "io/cancel.h"
#include "light/sky_file.h"
#include "scene/scene_library.h"

namespace probebake {

class SceneCache {
  public:
    struct Options {
        uint64_t memory_budget_bytes = uint64_t{8} << 30;
        /// Where trees, grids and light are kept between runs; none: nowhere.
        std::optional<std::filesystem::path> tree_cache_dir;
        /// Of that folder, beyond which what was not used for longest is removed.
        uint64_t cache_bytes = uint64_t{64} << 30;
        /// How files of other programs are imported; none: by this process.
        std::optional<ImportProcess> importer;
    };

    SceneCache(RenderPool& pool, Options options);
    /// Waits for loads that are under way; imports are ended.
    ~SceneCache();
    SceneCache(const SceneCache&) = delete;
    SceneCache& operator=(const SceneCache&) = delete;

    /// The scene of this file. A file whose content changed is another scene. Throws what
    /// load_scene throws, and Cancelled.
    std::shared_ptr<const Scene> get(const SceneFile& file, const CancelToken& cancel);

    /// The picture of a sky, decoded as scenes are imported. Throws IoError and Cancelled.
    SkyFile sky(const std::filesystem::path& picture, const CancelToken& cancel) const;

    /// Bytes of the scenes that are loaded.
    uint64_t memory_bytes() const;

  private:
    struct Entry {
        bool loading = true;
        std::shared_ptr<const Scene> scene;  // or:
        std::exception_ptr failure;
        uint64_t last_use = 0;
    };
    struct Loader {
        std::shared_ptr<Entry> entry;
        std::jthread thread;
    };

    void load(const SceneFile& file, const std::string& key, const std::shared_ptr<Entry>& entry);
    std::shared_ptr<const Scene> load_or_throw(const SceneFile& file);
    // With mutex_ held:
    uint64_t loaded_bytes() const;
    void evict();
    void join_loaders();  // those that are done

    RenderPool& pool_;
    const Options options_;
    CancelToken end_;

    mutable std::mutex mutex_;
    // Guarded by mutex_:
    std::condition_variable changed_;
    std::map<std::string, std::shared_ptr<Entry>> entries_;  // by content hash
    uint64_t uses_ = 0;
    std::list<Loader> loaders_;
};

}  // namespace probebake
