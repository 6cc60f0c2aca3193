#include "scene/gltf/gltf_load.h"

#include <algorithm>

#include "scene/gltf/gltf_document.h"

namespace probebake {
namespace {

/// What tinygltf's callbacks are given. It asks for buffers in the document's order, with names
/// that it has decoded in a way of its own ('+' becomes a space).
struct Buffers {
    const std::vector<std::string>& names;
    const ReadInner& read;
    const std::string& file;
    size_t next = 0;
};

/// Names are the document's, checked; nothing is expanded, nothing is written.
tinygltf::FsCallbacks callbacks(Buffers& buffers) {
    tinygltf::FsCallbacks calls{};
    calls.FileExists = [](const std::string&, void*) { return true; };
    calls.ExpandFilePath = [](const std::string& name, void*) { return name; };
    calls.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*,
                             const std::string& asked, void* user) {
        auto& [names, read, file, next] = *static_cast<Buffers*>(user);
        if (asked.starts_with("data:") || next >= names.size()) {
            throw IoError(file, "a buffer is a data: URI of a kind that is not understood");
        }
        const std::string& name = names[next++];
        const auto bytes = read_inner(read, name, file);
        if (!bytes) throw IoError(file, "the buffer \"" + name + "\" is missing");
        const auto* first = reinterpret_cast<const unsigned char*>(bytes->data());
        out->assign(first, first + bytes->size());
        return true;
    };
    calls.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&,
                              void*) { return false; };
    calls.user_data = &buffers;
    return calls;
}

/// Keeps the bytes of a picture that stands in the file; it is decoded when a material shows it.
bool keep_image(tinygltf::Image* image, int, std::string*, std::string*, int, int,
                const unsigned char* bytes, int size, void*) {
    image->image.assign(bytes, bytes + size);
    image->as_is = true;
    return true;
}

}  // namespace

tinygltf::Model load_gltf(std::span<const std::byte> bytes, const ReadInner& read,
                          const std::string& file, std::vector<std::string>& warnings) {
    const GltfDocument document = check_gltf(bytes, file);
    tinygltf::TinyGLTF loader;
    Buffers buffers{document.buffers, read, file};
    loader.SetFsCallbacks(callbacks(buffers));
    loader.SetImageLoader(keep_image, nullptr);
    tinygltf::Model model;
    std::string error;
    std::string warning;
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    const auto size = static_cast<unsigned>(bytes.size());
    const bool read_whole =
        document.is_binary
            ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                          reinterpret_cast<const unsigned char*>(text), size)
            : loader.LoadASCIIFromString(&model, &error, &warning, text, size, "");
    std::replace(error.begin(), error.end(), '\n', ' ');
    if (!read_whole) throw IoError(file, "cannot be read: " + error.substr(0, 500));
    // About skins and animations, or parts of materials that are not used here.
    if (!error.empty()) warnings.push_back("tinygltf: " + error.substr(0, 200));
    return model;
}

}  // namespace probebake
