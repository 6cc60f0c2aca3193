#include "scene/folder_files.h"

#include <algorithm>

#include "io/file_beneath.h"

namespace probebake {
namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;

}  // namespace

bool is_inner_name(std::string_view name) {
    if (name.empty() || name.size() > 1024) return false;
    const auto refused = [](char c) {
        return (c >= 0 && c < ' ') || c == 127 || c == '\\' || c == ':';
    };
    if (std::any_of(name.begin(), name.end(), refused)) return false;
    for (size_t at = 0; at <= name.size();) {
        const size_t end = std::min(name.find('/', at), name.size());
        const std::string_view part = name.substr(at, end - at);
        if (part.empty() || part.size() > 255 || part == "." || part == "..") return false;
        at = end + 1;
    }
    return true;
}

ReadInner files_beneath(std::filesystem::path folder) {
    return [folder = std::move(folder)](const std::string& name) {
        return find_file_beneath(folder, name, kMaxFileBytes);
    };
}

std::optional<std::vector<std::byte>> read_inner(const ReadInner& read, const std::string& name,
                                                 const std::string& file) {
    if (!is_inner_name(name)) {
        throw IoError(file, "refers to \"" + name.substr(0, 100) +
                                "\", expected the name of a file in its own folder or beneath it");
    }
    return read(name);
}

}  // namespace probebake
