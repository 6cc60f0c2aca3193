// The values of a glTF accessor: strided, normalised, sparse; every byte within its buffer.
//
// Source: glTF 2.0, section 3.6.2. A sparse accessor without a buffer view begins as zeros.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scene/gltf/tinygltf.h"

namespace probebake {

class GltfAccessor {
  public:
    /// The model's indices and buffer views are as check_gltf leaves them. Throws IoError, naming
    /// file and accessor, where elements lie outside of their buffer view, or are more than
    /// max_elements.
    GltfAccessor(const tinygltf::Model& model, int index, uint64_t max_elements,
                 const std::string& file);

    size_t size() const { return size_; }
    int components() const { return components_; }
    bool is_float() const { return component_type_ == TINYGLTF_COMPONENT_TYPE_FLOAT; }
    bool is_unsigned() const {
        return component_type_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
               component_type_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
               component_type_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    }
    bool is_normalized() const { return normalized_; }
    /// No bytes stand behind it: all zeros.
    bool is_empty() const { return dense_.empty() && sparse_.empty(); }
    /// A component of element i; normalised integers as numbers of −1 to 1.
    double value(size_t i, int component) const;
    /// Of unsigned types.
    uint32_t integer(size_t i) const { return static_cast<uint32_t>(raw(i, 0)); }

    [[noreturn]] void fail(const std::string& problem) const;

  private:
    struct Replaced {
        uint32_t element = 0;
        uint32_t at = 0;  // of its values
    };
    using Bytes = std::span<const unsigned char>;

    double raw(size_t i, int component) const;
    void read_sparse(const tinygltf::Model& model, const tinygltf::Accessor& accessor);
    /// `count` elements of `size` bytes, `stride` bytes apart, of a buffer view.
    Bytes bytes_of(const tinygltf::Model& model, int view, uint64_t offset, uint64_t count,
                   uint64_t size, uint64_t stride) const;

    const std::string& file_;
    int index_;
    size_t size_ = 0;
    int components_ = 0;
    int component_type_ = 0;
    bool normalized_ = false;
    size_t stride_bytes_ = 0;
    Bytes dense_;  // from the first element on
    Bytes sparse_values_;
    std::vector<Replaced> sparse_;  // ascending
};

}  // namespace probebake
