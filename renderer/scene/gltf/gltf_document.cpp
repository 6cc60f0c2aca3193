#include "scene/gltf/gltf_document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "io/byte_reader.h"
#include "io/json.h"
#include "scene/folder_files.h"

namespace probebake {
namespace {

constexpr JsonLimits kJsonLimits{.max_depth = 64, .max_values = 4'000'000};
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;
constexpr uint64_t kMaxBufferBytes = uint64_t{1} << 31;  // of all buffers
constexpr std::string_view kLights = "/extensions/KHR_lights_punctual/lights";

enum class Form { kIndex, kSize, kNumber, kNumbers, kText, kTruth, kObject };

/// '*' stands for every element of an array, '@' for every member of an object.
struct Field {
    const char* path;
    Form form;
    bool required = false;
    size_t count = 0;              // of kNumbers
    const char* target = nullptr;  // of kIndex: the array that it counts
};

constexpr const char* kBaseTexture = "/materials/*/pbrMetallicRoughness/baseColorTexture";
constexpr const char* kEmissiveTexture = "/materials/*/emissiveTexture";

const std::vector<Field>& fields() {
    static const std::vector<Field> made = [] {
        std::vector<Field> all = {
            {"/asset/version", Form::kText, true},
            {"/extensionsRequired/*", Form::kText},
            {"/scene", Form::kIndex, false, 0, "/scenes"},
            {"/scenes/*/nodes/*", Form::kIndex, false, 0, "/nodes"},
            {"/nodes/*/children/*", Form::kIndex, false, 0, "/nodes"},
            {"/nodes/*/mesh", Form::kIndex, false, 0, "/meshes"},
            {"/nodes/*/skin", Form::kSize},
            {"/nodes/*/matrix", Form::kNumbers, false, 16},
            {"/nodes/*/rotation", Form::kNumbers, false, 4},
            {"/nodes/*/scale", Form::kNumbers, false, 3},
            {"/nodes/*/translation", Form::kNumbers, false, 3},
            {"/nodes/*/extensions/KHR_lights_punctual/light", Form::kIndex, false, 0,
             kLights.data()},
            {"/extensions/KHR_lights_punctual/lights/*/type", Form::kText, true},
            {"/extensions/KHR_lights_punctual/lights/*/color", Form::kNumbers, false, 3},
            {"/extensions/KHR_lights_punctual/lights/*/intensity", Form::kNumber},
            {"/meshes/*/primitives/*/attributes", Form::kObject, true},
            {"/meshes/*/primitives/*/attributes/@", Form::kIndex, false, 0, "/accessors"},
            {"/meshes/*/primitives/*/indices", Form::kIndex, false, 0, "/accessors"},
            {"/meshes/*/primitives/*/material", Form::kIndex, false, 0, "/materials"},
            {"/meshes/*/primitives/*/mode", Form::kSize},
            {"/accessors/*/bufferView", Form::kIndex, false, 0, "/bufferViews"},
            {"/accessors/*/byteOffset", Form::kSize},
            {"/accessors/*/componentType", Form::kSize, true},
            {"/accessors/*/normalized", Form::kTruth},
            {"/accessors/*/count", Form::kSize, true},
            {"/accessors/*/type", Form::kText, true},
            {"/accessors/*/sparse/count", Form::kSize, true},
            {"/accessors/*/sparse/indices/bufferView", Form::kIndex, true, 0, "/bufferViews"},
            {"/accessors/*/sparse/indices/byteOffset", Form::kSize},
            {"/accessors/*/sparse/indices/componentType", Form::kSize, true},
            {"/accessors/*/sparse/values/bufferView", Form::kIndex, true, 0, "/bufferViews"},
            {"/accessors/*/sparse/values/byteOffset", Form::kSize},
            {"/bufferViews/*/buffer", Form::kIndex, true, 0, "/buffers"},
            {"/bufferViews/*/byteOffset", Form::kSize},
            {"/bufferViews/*/byteLength", Form::kSize, true},
            {"/bufferViews/*/byteStride", Form::kSize},
            {"/buffers/*/byteLength", Form::kSize, true},
            {"/buffers/*/uri", Form::kText},
            {"/images/*/bufferView", Form::kIndex, false, 0, "/bufferViews"},
            {"/images/*/uri", Form::kText},
            {"/textures/*/source", Form::kIndex, false, 0, "/images"},
            {"/textures/*/sampler", Form::kIndex, false, 0, "/samplers"},
            {"/samplers/*/wrapS", Form::kSize},
            {"/samplers/*/wrapT", Form::kSize},
            {"/materials/*/name", Form::kText},
            {"/materials/*/pbrMetallicRoughness/baseColorFactor", Form::kNumbers, false, 4},
            {"/materials/*/emissiveFactor", Form::kNumbers, false, 3},
            {"/materials/*/extensions/KHR_materials_emissive_strength/emissiveStrength",
             Form::kNumber},
            {"/materials/*/alphaMode", Form::kText},
            {"/materials/*/alphaCutoff", Form::kNumber},
            {"/materials/*/doubleSided", Form::kTruth},
        };
        static std::vector<std::string> paths;  // of what both textures have
        paths.reserve(16);
        const auto of_textures = [&](const std::string& rest, Field field) {
            for (const char* texture : {kBaseTexture, kEmissiveTexture}) {
                field.path = paths.emplace_back(texture + rest).c_str();
                all.push_back(field);
            }
        };
        const std::string transform = "/extensions/KHR_texture_transform/";
        of_textures("/index", {nullptr, Form::kIndex, true, 0, "/textures"});
        of_textures("/texCoord", {nullptr, Form::kSize});
        of_textures(transform + "offset", {nullptr, Form::kNumbers, false, 2});
        of_textures(transform + "scale", {nullptr, Form::kNumbers, false, 2});
        of_textures(transform + "rotation", {nullptr, Form::kNumber});
        of_textures(transform + "texCoord", {nullptr, Form::kSize});
        return all;
    }();
    return made;
}

constexpr std::string_view kUnderstood[] = {
    "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_unlit",
    "KHR_mesh_quantization", "KHR_texture_transform"};

class Check {
  public:
    Check(const Json& document, const std::string& file) : document_(document), file_(file) {}

    [[noreturn]] void fail(const std::string& pointer, const std::string& problem) const {
        throw IoError(file_, (pointer.empty() ? "the document" : pointer) + ": " + problem);
    }
    void run() {
        for (const Field& field : fields()) visit(document_, "", field.path, field);
        if (!document_.contains("asset")) fail("/asset", "is required");
        if (!document_["asset"]["version"].get_ref<const std::string&>().starts_with("2.")) {
            fail("/asset/version", "expected \"2.0\"");
        }
        extensions();
        buffers();
    }
    /// Names of files in a section's URIs.
    std::vector<std::string> names_in(const std::string& section) const {
        std::vector<std::string> names;
        if (!document_.contains(section)) return names;
        const Json& all = document_[section];
        for (size_t i = 0; i < all.size(); ++i) {
            if (!all[i].contains("uri")) continue;
            const std::string pointer = "/" + section + "/" + std::to_string(i) + "/uri";
            auto name = name_of_uri(all[i]["uri"].get<std::string>(), pointer, file_);
            if (name) names.push_back(*std::move(name));
        }
        return names;
    }

  private:
    /// `rest` is what is left of the field's path below the value.
    void visit(const Json& value, const std::string& pointer, std::string_view rest,
               const Field& field) const {
        if (rest.empty()) return leaf(value, pointer, field);
        rest.remove_prefix(1);
        const size_t end = std::min(rest.find('/'), rest.size());
        const std::string step(rest.substr(0, end));
        rest.remove_prefix(end);
        if (step == "*") {
            if (!value.is_array()) fail(pointer, "expected an array");
            for (size_t i = 0; i < value.size(); ++i) {
                visit(value[i], pointer + "/" + std::to_string(i), rest, field);
            }
            return;
        }
        if (!value.is_object()) fail(pointer, "expected an object");
        if (step == "@") {
            for (const auto& [key, member] : value.items()) {
                std::string below = pointer;
                below.append("/").append(key);
                visit(member, below, rest, field);
            }
            return;
        }
        const auto at = value.find(step);
        if (at != value.end()) return visit(*at, pointer + "/" + step, rest, field);
        if (rest.empty() && field.required) fail(pointer + "/" + step, "is required");
    }
    void leaf(const Json& value, const std::string& pointer, const Field& field) const {
        switch (field.form) {
            case Form::kIndex:
                return index(value, pointer, field);
            case Form::kSize:
                size(value, pointer);
                return;
            case Form::kNumber:
                if (!value.is_number()) fail(pointer, "expected a number");
                return;
            case Form::kNumbers:
                if (!value.is_array() || value.size() != field.count ||
                    !std::all_of(value.begin(), value.end(),
                                 [](const Json& x) { return x.is_number(); })) {
                    fail(pointer, "expected " + std::to_string(field.count) + " numbers");
                }
                return;
            case Form::kText:
                if (!value.is_string()) fail(pointer, "expected a string");
                return;
            case Form::kTruth:
                if (!value.is_boolean()) fail(pointer, "expected true or false");
                return;
            case Form::kObject:
                if (!value.is_object()) fail(pointer, "expected an object");
        }
    }
    /// What fits the integers of tinygltf.
    uint64_t size(const Json& value, const std::string& pointer) const {
        constexpr uint64_t kMost = std::numeric_limits<int32_t>::max();
        if (!value.is_number_unsigned() || value.get<uint64_t>() > kMost) {
            fail(pointer, "expected an integer from 0 to " + std::to_string(kMost));
        }
        return value.get<uint64_t>();
    }
    void index(const Json& value, const std::string& pointer, const Field& field) const {
        const Json::json_pointer target{std::string(field.target)};
        const size_t count = document_.contains(target) ? document_[target].size() : 0;
        const uint64_t at = size(value, pointer);
        if (at >= count) {
            fail(pointer, "is " + std::to_string(at) + ", but " + field.target + " has " +
                              std::to_string(count) + " elements");
        }
    }
    void extensions() const {
        if (!document_.contains("extensionsRequired")) return;
        const Json& required = document_["extensionsRequired"];
        for (size_t i = 0; i < required.size(); ++i) {
            const auto& name = required[i].get_ref<const std::string&>();
            if (gltf_understands(name)) continue;
            const bool compression =
                name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression";
            fail("/extensionsRequired/" + std::to_string(i),
                 "needs " + name.substr(0, 100) +
                     (compression ? ", expected a mesh that is not compressed"
                                  : ", which is not understood"));
        }
    }
    void buffers() const {
        uint64_t total = 0;
        std::vector<uint64_t> lengths;
        const Json none = Json::array();
        const auto& all = document_.contains("buffers") ? document_["buffers"] : none;
        for (size_t i = 0; i < all.size(); ++i) {
            lengths.push_back(all[i]["byteLength"].get<uint64_t>());
            total += lengths.back();
            const std::string pointer = "/buffers/" + std::to_string(i) + "/byteLength";
            if (lengths.back() == 0) fail(pointer, "is 0, expected at least 1");
            if (total > kMaxBufferBytes) {
                fail(pointer,
                     "buffers of more than " + std::to_string(kMaxBufferBytes) + " bytes in all");
            }
        }
        const auto& views = document_.contains("bufferViews") ? document_["bufferViews"] : none;
        for (size_t i = 0; i < views.size(); ++i) {
            const uint64_t length = views[i]["byteLength"].get<uint64_t>();
            const uint64_t end = views[i].value("byteOffset", uint64_t{0}) + length;
            const uint64_t buffer = views[i]["buffer"].get<uint64_t>();
            if (length == 0 || end > lengths[buffer]) {
                fail("/bufferViews/" + std::to_string(i),
                     "holds " + std::to_string(length) + " bytes and ends at byte " +
                         std::to_string(end) + " of buffer " + std::to_string(buffer) +
                         ", which has " + std::to_string(lengths[buffer]));
            }
        }
    }

    const Json& document_;
    const std::string& file_;
};

/// The JSON chunk; the second chunk, if any, is whole and ends within the file.
std::string_view json_of_glb(std::span<const std::byte> bytes, const std::string& file) {
    ByteReader reader(file, bytes);
    reader.take_text(4, "the signature");
    const auto version = reader.read<uint32_t>("the version");
    if (version != 2) {
        reader.fail_at(4, "is GLB version " + std::to_string(version) + ", expected 2");
    }
    const auto length = reader.read<uint32_t>("the length");
    if (length != bytes.size()) {
        reader.fail_at(8, "the header says " + std::to_string(length) + " bytes, the file has " +
                              std::to_string(bytes.size()));
    }
    std::string_view json;
    for (int chunk = 0; !reader.done() && chunk < 2; ++chunk) {
        const uint64_t at = reader.offset();
        const auto size = reader.read<uint32_t>("the length of a chunk");
        const std::string_view type = reader.take_text(4, "the type of a chunk");
        const std::string_view content = reader.take_text(size, "a chunk");
        if (size < 4 || size % 4 != 0) {
            reader.fail_at(
                at, "a chunk of " + std::to_string(size) + " bytes, expected a multiple of 4");
        }
        if (type != (chunk == 0 ? std::string_view("JSON") : std::string_view("BIN\0", 4))) {
            reader.fail_at(at, "expected a JSON chunk, then a BIN chunk");
        }
        if (chunk == 0) json = content;
    }
    if (json.empty()) reader.fail("expected a JSON chunk");
    return json;
}

}  // namespace

bool gltf_understands(const std::string& extension) {
    return std::find(std::begin(kUnderstood), std::end(kUnderstood), extension) !=
           std::end(kUnderstood);
}

GltfDocument check_gltf(std::span<const std::byte> bytes, const std::string& file) {
    if (bytes.size() > kMaxFileBytes) {
        throw IoError(file, "has more than " + std::to_string(kMaxFileBytes) + " bytes");
    }
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    GltfDocument found;
    found.is_binary = text.starts_with("glTF");
    if (found.is_binary) text = json_of_glb(bytes, file);
    Json document;
    try {
        document = parse_json(text, kJsonLimits);
    } catch (const SpecError& error) {
        throw IoError(file, error.what());
    }
    Check check(document, file);
    check.run();
    found.buffers = check.names_in("buffers");
    found.images = check.names_in("images");
    return found;
}

std::optional<std::string> name_of_uri(const std::string& uri, const std::string& pointer,
                                       const std::string& file) {
    if (uri.starts_with("data:")) return std::nullopt;
    std::string name;
    for (size_t i = 0; i < uri.size(); ++i) {
        const auto digit = [&](size_t at) {
            constexpr std::string_view kDigits = "0123456789abcdefABCDEF";
            const size_t found = at < uri.size() ? kDigits.find(uri[at]) : std::string_view::npos;
            return found == std::string_view::npos
                       ? -1
                       : static_cast<int>(found < 16 ? found : found - 6);
        };
        if (uri[i] == '%' && digit(i + 1) >= 0 && digit(i + 2) >= 0) {
            name.push_back(static_cast<char>(digit(i + 1) * 16 + digit(i + 2)));
            i += 2;
        } else {
            name.push_back(uri[i]);
        }
    }
    if (!is_inner_name(name)) {
        throw IoError(file, pointer + ": is \"" + uri.substr(0, 100) +
                                "\", expected a data: URI or the name of a file in the same "
                                "folder or beneath it");
    }
    return name;
}

}  // namespace probebake
