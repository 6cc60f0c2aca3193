#include "scene/gltf/gltf_accessor.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "io/io_error.h"

namespace probebake {
namespace {

/// 0 for what is no component type of glTF.
uint64_t bytes_of_component(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return 4;
        default:
            return 0;
    }
}

template <class T>
double read_as(const unsigned char* at) {
    T value;
    std::memcpy(&value, at, sizeof(T));
    return static_cast<double>(value);
}

double read_component(const unsigned char* at, int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return read_as<int8_t>(at);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return read_as<uint8_t>(at);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return read_as<int16_t>(at);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return read_as<uint16_t>(at);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return read_as<uint32_t>(at);
        default:
            return read_as<float>(at);
    }
}

double largest_of(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return std::numeric_limits<int8_t>::max();
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return std::numeric_limits<uint8_t>::max();
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return std::numeric_limits<int16_t>::max();
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return std::numeric_limits<uint16_t>::max();
        default:
            return 1.0;
    }
}

}  // namespace

GltfAccessor::GltfAccessor(const tinygltf::Model& model, int index, uint64_t max_elements,
                           const std::string& file)
    : file_(file), index_(index) {
    const tinygltf::Accessor& accessor = model.accessors[static_cast<size_t>(index)];
    component_type_ = accessor.componentType;
    normalized_ = accessor.normalized;
    const uint64_t component_bytes = bytes_of_component(component_type_);
    const bool is_vector =
        accessor.type == TINYGLTF_TYPE_SCALAR ||
        (accessor.type >= TINYGLTF_TYPE_VEC2 && accessor.type <= TINYGLTF_TYPE_VEC4);
    if (component_bytes == 0 || !is_vector) fail("is of a type that is not expected here");
    components_ = accessor.type == TINYGLTF_TYPE_SCALAR ? 1 : accessor.type;
    if (accessor.count < 1 || accessor.count > max_elements) {
        fail("has " + std::to_string(accessor.count) + " elements, expected 1 to " +
             std::to_string(max_elements));
    }
    size_ = accessor.count;
    const uint64_t element_bytes = component_bytes * static_cast<uint64_t>(components_);
    stride_bytes_ = element_bytes;
    if (accessor.bufferView >= 0) {
        const auto& view = model.bufferViews[static_cast<size_t>(accessor.bufferView)];
        if (view.byteStride != 0) stride_bytes_ = view.byteStride;
        if (stride_bytes_ < element_bytes) fail("has elements that overlap");
        dense_ = bytes_of(model, accessor.bufferView, accessor.byteOffset, size_, element_bytes,
                          stride_bytes_);
    }
    if (accessor.sparse.isSparse) read_sparse(model, accessor);
}

void GltfAccessor::fail(const std::string& problem) const {
    throw IoError(file_, "/accessors/" + std::to_string(index_) + ": " + problem);
}

GltfAccessor::Bytes GltfAccessor::bytes_of(const tinygltf::Model& model, int view, uint64_t offset,
                                           uint64_t count, uint64_t size, uint64_t stride) const {
    const tinygltf::BufferView& from = model.bufferViews[static_cast<size_t>(view)];
    const auto& buffer = model.buffers[static_cast<size_t>(from.buffer)].data;
    // All factors are below 2^31.
    const uint64_t needed = offset + (count - 1) * stride + size;
    if (needed > from.byteLength || from.byteOffset + from.byteLength > buffer.size()) {
        fail("needs " + std::to_string(needed) + " bytes, /bufferViews/" + std::to_string(view) +
             " has " + std::to_string(from.byteLength));
    }
    return Bytes(buffer).subspan(from.byteOffset + offset, needed - offset);
}

void GltfAccessor::read_sparse(const tinygltf::Model& model, const tinygltf::Accessor& accessor) {
    const auto& sparse = accessor.sparse;
    const int type = sparse.indices.componentType;
    const bool is_index = type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                          type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                          type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    if (!is_index) fail("has sparse indices that are no unsigned integers");
    const auto count = static_cast<uint64_t>(sparse.count);
    if (sparse.count < 1 || count > size_) {
        fail("replaces " + std::to_string(sparse.count) + " of " + std::to_string(size_) +
             " elements");
    }
    const uint64_t index_bytes = bytes_of_component(type);
    const Bytes indices =
        bytes_of(model, sparse.indices.bufferView, static_cast<uint64_t>(sparse.indices.byteOffset),
                 count, index_bytes, index_bytes);
    const uint64_t element_bytes =
        bytes_of_component(component_type_) * static_cast<uint64_t>(components_);
    sparse_values_ =
        bytes_of(model, sparse.values.bufferView, static_cast<uint64_t>(sparse.values.byteOffset),
                 count, element_bytes, element_bytes);
    sparse_.reserve(count);
    for (uint64_t i = 0; i < count; ++i) {
        const auto element = static_cast<uint32_t>(read_component(&indices[i * index_bytes], type));
        if (element >= size_ || (i > 0 && element <= sparse_.back().element)) {
            fail("sparse index " + std::to_string(element) + ", expected ascending ones below " +
                 std::to_string(size_));
        }
        sparse_.push_back({element, static_cast<uint32_t>(i)});
    }
}

double GltfAccessor::raw(size_t i, int component) const {
    const uint64_t component_bytes = bytes_of_component(component_type_);
    const uint64_t shift = component_bytes * static_cast<uint64_t>(component);
    if (!sparse_.empty()) {
        const auto at = std::lower_bound(
            sparse_.begin(), sparse_.end(), i,
            [](const Replaced& replaced, size_t element) { return replaced.element < element; });
        if (at != sparse_.end() && at->element == i) {
            const uint64_t element_bytes = component_bytes * static_cast<uint64_t>(components_);
            return read_component(&sparse_values_[at->at * element_bytes + shift], component_type_);
        }
    }
    if (dense_.empty()) return 0.0;
    return read_component(&dense_[i * stride_bytes_ + shift], component_type_);
}

double GltfAccessor::value(size_t i, int component) const {
    const double x = raw(i, component);
    return normalized_ ? std::max(-1.0, x / largest_of(component_type_)) : x;
}

}  // namespace probebake
