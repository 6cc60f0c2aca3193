// glTF documents for tests: accessors over one buffer, embedded as a data: URI or as a GLB.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "io/json.h"

namespace probebake::test {

inline std::string base64(std::string_view bytes) {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const auto byte = [&](size_t at) -> uint32_t {
            return at < bytes.size() ? static_cast<uint8_t>(bytes[at]) : 0u;
        };
        const uint32_t triple = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
        for (size_t digit = 0; digit < 4; ++digit) {
            out.push_back(i + digit > bytes.size() ? '='
                                                   : kDigits[triple >> (18 - 6 * digit) & 63u]);
        }
    }
    return out;
}

template <class T>
void append_value(std::string& bytes, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.append(raw, sizeof(T));
}

struct GltfWriter {
    Json document = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
    std::string buffer;

    /// Appends the values as an accessor of elements of `type`; returns its index.
    template <class T>
    int accessor(const std::string& type, int component_type, const std::vector<T>& values,
                 bool normalized = false) {
        const int view = buffer_view(values);
        const size_t components = type == "SCALAR" ? 1 : static_cast<size_t>(type[3] - '0');
        Json made = {{"bufferView", view},
                     {"componentType", component_type},
                     {"count", values.size() / components},
                     {"type", type}};
        if (normalized) made["normalized"] = true;
        document["accessors"].push_back(made);
        return static_cast<int>(document["accessors"].size()) - 1;
    }
    template <class T>
    int buffer_view(const std::vector<T>& values) {
        buffer.resize((buffer.size() + 3) / 4 * 4);
        const size_t begin = buffer.size();
        for (const T value : values) append_value(buffer, value);
        document["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", buffer.size() - begin}});
        return static_cast<int>(document["bufferViews"].size()) - 1;
    }
    int positions(const std::vector<float>& values) { return accessor("VEC3", 5126, values); }
    /// Adds a mesh of one primitive; returns its index.
    int mesh(const Json& primitive) {
        document["meshes"].push_back({{"primitives", {primitive}}});
        return static_cast<int>(document["meshes"].size()) - 1;
    }
    /// Adds a node to the scene.
    void node(const Json& made) {
        document["nodes"].push_back(made);
        document["scenes"][0]["nodes"].push_back(document["nodes"].size() - 1);
    }

    std::string text() const {
        Json whole = document;
        if (!buffer.empty()) {
            whole["buffers"] = {
                {{"byteLength", buffer.size()},
                 {"uri", "data:application/octet-stream;base64," + base64(buffer)}}};
        }
        return whole.dump();
    }
    std::string binary() const {
        Json whole = document;
        whole["buffers"] = {{{"byteLength", buffer.size()}}};
        std::string json = whole.dump();
        json.resize((json.size() + 3) / 4 * 4, ' ');
        std::string bin = buffer;
        bin.resize((bin.size() + 3) / 4 * 4);
        std::string out = "glTF";
        append_value(out, uint32_t{2});
        append_value(out, static_cast<uint32_t>(12 + 8 + json.size() + 8 + bin.size()));
        append_value(out, static_cast<uint32_t>(json.size()));
        out += "JSON" + json;
        append_value(out, static_cast<uint32_t>(bin.size()));
        out += std::string("BIN\0", 4) + bin;
        return out;
    }
};

/// A triangle (0,0,0), (1,0,0), (0,1,0) in one node.
inline GltfWriter gltf_triangle() {
    GltfWriter writer;
    const int positions = writer.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    writer.node({{"mesh", writer.mesh({{"attributes", {{"POSITION", positions}}}})}});
    return writer;
}

}  // namespace probebake::test
