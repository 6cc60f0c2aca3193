#include "jobs/artifact_store.h"

#include <algorithm>
#include <system_error>

#include "io/file.h"

namespace probebake {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kBlockBytes = 4096;

void make_folder(const fs::path& path) {
    std::error_code error;
    fs::create_directories(path, error);
    if (error) throw IoError(path.filename().string(), "cannot be made: " + error.message());
}

}  // namespace

ArtifactStore::ArtifactStore(const fs::path& folder) : data_(folder) {}

void ArtifactStore::add_job(const std::string& job) {
    make_folder(folder_of(job));
    const std::lock_guard lock(mutex_);
    jobs_[job];
}

void ArtifactStore::publish(const std::string& job, const std::string& probe,
                            const ProbeResult& result) {
    publish(job, {.probe = probe, .state = std::string(name_of(result.state))}, result.files);
}

void ArtifactStore::publish(const std::string& job, const GridResult& result) {
    publish(job, {.probe = result.grid, .state = result.state, .is_grid = true}, result.files);
}

void ArtifactStore::publish(const std::string& job, StoredUnit unit,
                            std::span<const ProductFile> files) {
    const fs::path folder = folder_of(job) / "probes" / unit.probe / unit.state;
    make_folder(folder);
    uint64_t bytes = 0;
    for (const ProductFile& file : files) {
        write_file_atomically(folder / file.name, file.bytes);
        unit.files.push_back({file.name, file.size_bytes, file.sha256});
        bytes += std::max(kBlockBytes, file.size_bytes);
    }
    const std::lock_guard lock(mutex_);
    const auto at = jobs_.find(job);
    if (at == jobs_.end()) return;
    Index& index = at->second;
    index.by_name.emplace(unit.probe + "/" + unit.state, index.units.size());
    index.units.push_back(std::move(unit));
    index.bytes += bytes;
}

void ArtifactStore::write_report(const std::string& job, const Json& report) {
    write_file_atomically(folder_of(job) / "report.json", dump_json(report) + "\n");
}

void ArtifactStore::remove_job(const std::string& job) {
    {
        const std::lock_guard lock(mutex_);
        jobs_.erase(job);
    }
    std::error_code ignored;  // what is left is removed at the next start
    fs::remove_all(folder_of(job), ignored);
}

std::vector<StoredUnit> ArtifactStore::units(const std::string& job, size_t first,
                                             size_t count) const {
    const std::lock_guard lock(mutex_);
    const auto at = jobs_.find(job);
    if (at == jobs_.end()) return {};
    const std::vector<StoredUnit>& all = at->second.units;
    const size_t begin = std::min(first, all.size());
    const size_t end = begin + std::min(count, all.size() - begin);
    return {all.begin() + static_cast<std::ptrdiff_t>(begin),
            all.begin() + static_cast<std::ptrdiff_t>(end)};
}

size_t ArtifactStore::unit_count(const std::string& job) const {
    const std::lock_guard lock(mutex_);
    const auto at = jobs_.find(job);
    return at == jobs_.end() ? 0 : at->second.units.size();
}

uint64_t ArtifactStore::bytes_of(const std::string& job) const {
    const std::lock_guard lock(mutex_);
    const auto at = jobs_.find(job);
    return at == jobs_.end() ? 0 : at->second.bytes;
}

std::optional<OpenArtifact> ArtifactStore::open(const std::string& job, const std::string& probe,
                                                const std::string& state,
                                                const std::string& name) const {
    StoredFile found;
    {
        const std::lock_guard lock(mutex_);
        const auto at = jobs_.find(job);
        if (at == jobs_.end()) return std::nullopt;
        const auto unit = at->second.by_name.find(probe + "/" + state);
        if (unit == at->second.by_name.end()) return std::nullopt;
        const std::vector<StoredFile>& files = at->second.units[unit->second].files;
        const auto file = std::find_if(files.begin(), files.end(),
                                       [&](const StoredFile& f) { return f.name == name; });
        if (file == files.end()) return std::nullopt;
        found = *file;
    }
    std::shared_ptr<const OpenFile> content =
        OpenFile::open(folder_of(job) / "probes" / probe / state / name);
    if (!content) return std::nullopt;  // the job was removed in between
    if (content->size_bytes() != found.size_bytes) {
        throw IoError(name, "has " + std::to_string(content->size_bytes()) + " bytes, expected " +
                                std::to_string(found.size_bytes));
    }
    return OpenArtifact{std::move(found), std::move(content)};
}

std::shared_ptr<const OpenFile> ArtifactStore::open_report(const std::string& job) const {
    return OpenFile::open(folder_of(job) / "report.json");
}

}  // namespace probebake
