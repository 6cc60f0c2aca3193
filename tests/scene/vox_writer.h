// Writes small .vox files for tests: well-formed ones, and ones that lie.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "math/vec.h"

namespace probebake::test {

using Bytes = std::vector<std::byte>;
using Pairs = std::vector<std::pair<std::string, std::string>>;

/// The content of one chunk.
class VoxContent {
  public:
    VoxContent& i32(int64_t value) {
        for (int byte = 0; byte < 4; ++byte) u8(static_cast<uint8_t>(value >> (8 * byte)));
        return *this;
    }
    VoxContent& u8(uint8_t value) {
        bytes_.push_back(std::byte{value});
        return *this;
    }
    VoxContent& text(const std::string& characters) {
        for (const char c : characters) u8(static_cast<uint8_t>(c));
        return *this;
    }
    VoxContent& string(const std::string& characters) {
        return i32(static_cast<int64_t>(characters.size())).text(characters);
    }
    VoxContent& dictionary(const Pairs& pairs) {
        i32(static_cast<int64_t>(pairs.size()));
        for (const auto& [key, value] : pairs) string(key).string(value);
        return *this;
    }
    VoxContent& append(const Bytes& bytes) {
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
        return *this;
    }
    const Bytes& bytes() const { return bytes_; }

  private:
    Bytes bytes_;
};

/// x, y, z, colour
using VoxelRow = std::array<uint8_t, 4>;

class VoxWriter {
  public:
    /// Where the next chunk will begin in the file.
    uint64_t offset() const { return 8 + 12 + children_.bytes().size(); }

    VoxWriter& chunk(const std::string& id, const VoxContent& content, const Bytes& inner = {}) {
        children_.text(id)
            .i32(static_cast<int64_t>(content.bytes().size()))
            .i32(static_cast<int64_t>(inner.size()))
            .append(content.bytes())
            .append(inner);
        return *this;
    }
    VoxWriter& size(const IVec3& size) {
        return chunk("SIZE", VoxContent().i32(size.x).i32(size.y).i32(size.z));
    }
    VoxWriter& voxels(const std::vector<VoxelRow>& rows) {
        VoxContent content;
        content.i32(static_cast<int64_t>(rows.size()));
        for (const VoxelRow& row : rows) {
            for (const uint8_t byte : row) content.u8(byte);
        }
        return chunk("XYZI", content);
    }
    VoxWriter& model(const IVec3& model_size, const std::vector<VoxelRow>& rows) {
        return size(model_size).voxels(rows);
    }
    /// frame: its attributes `_t`, `_r`
    VoxWriter& transform(int id, int child, const Pairs& frame = {}, const Pairs& attributes = {},
                         int layer = -1) {
        return chunk("nTRN", VoxContent()
                                 .i32(id)
                                 .dictionary(attributes)
                                 .i32(child)
                                 .i32(-1)
                                 .i32(layer)
                                 .i32(1)
                                 .dictionary(frame));
    }
    VoxWriter& group(int id, const std::vector<int>& children, const Pairs& attributes = {}) {
        VoxContent content;
        content.i32(id).dictionary(attributes).i32(static_cast<int64_t>(children.size()));
        for (const int child : children) content.i32(child);
        return chunk("nGRP", content);
    }
    VoxWriter& shape(int id, int model, const Pairs& attributes = {}) {
        return chunk("nSHP",
                     VoxContent().i32(id).dictionary(attributes).i32(1).i32(model).dictionary({}));
    }
    VoxWriter& layer(int id, const Pairs& attributes) {
        return chunk("LAYR", VoxContent().i32(id).dictionary(attributes).i32(-1));
    }
    VoxWriter& material(int id, const Pairs& properties) {
        return chunk("MATL", VoxContent().i32(id).dictionary(properties));
    }
    /// Colour i of the palette gets red = i, green = 255 − i, blue = 7.
    VoxWriter& palette() {
        VoxContent content;
        for (int i = 1; i <= 256; ++i) {
            const auto red = static_cast<uint8_t>(i);
            content.u8(red).u8(static_cast<uint8_t>(255 - red)).u8(7).u8(255);
        }
        return chunk("RGBA", content);
    }

    Bytes file(int version = 150) const {
        return VoxContent()
            .text("VOX ")
            .i32(version)
            .text("MAIN")
            .i32(0)
            .i32(static_cast<int64_t>(children_.bytes().size()))
            .append(children_.bytes())
            .bytes();
    }

  private:
    VoxContent children_;
};

/// A rotation as `_r` holds it: row i has its nonzero entry in column axis[i], of that sign.
inline std::string packed_rotation(const std::array<int, 3>& axis, const std::array<int, 3>& sign) {
    int bits = axis[0] | axis[1] << 2;
    for (int row = 0; row < 3; ++row) {
        if (sign[static_cast<size_t>(row)] < 0) bits |= 1 << (4 + row);
    }
    return std::to_string(bits);
}

}  // namespace probebake::test
