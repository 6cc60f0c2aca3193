#include "study/result_store.h"

#include "io/file.h"

namespace probebake::study {

ResultStore::ResultStore(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error) throw IoError(folder_.string(), "cannot be created: " + error.message());
}

std::filesystem::path ResultStore::path_of(const std::string& name) const {
    return folder_ / (name + ".json");
}

std::optional<Json> ResultStore::find(const std::string& name, const Json& key) const {
    const std::filesystem::path path = path_of(name);
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
    try {
        const std::vector<std::byte> bytes = read_file(path);
        const Json file = parse_json({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
        if (!file.is_object() || !file.contains("result")) return std::nullopt;
        if (file.value("key", Json()) != key) return std::nullopt;
        return file["result"];
    } catch (const IoError&) {
        return std::nullopt;
    } catch (const SpecError&) {
        return std::nullopt;
    }
}

void ResultStore::put(const std::string& name, const Json& key, const Json& result) const {
    write_file_atomically(path_of(name), dump_json({{"key", key}, {"result", result}}, 1) + "\n");
}

}  // namespace probebake::study
