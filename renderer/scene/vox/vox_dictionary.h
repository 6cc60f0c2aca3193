// The DICT of the .vox format: pairs of strings, and what their values mean.
//
//   number of pairs (4), per pair the key and the value, each as length (4) and characters
//
// Numbers are text. Source: (b) and (c) of MagicaVoxel-file-format-vox-extension.txt.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/byte_reader.h"

namespace probebake {

/// p -> R p + t with R a signed permutation (rotation or reflection): component i of the result is
/// sign[i] · p[axis[i]] + translation[i].
struct VoxTransform {
    std::array<size_t, 3> axis{0, 1, 2};
    std::array<int64_t, 3> sign{1, 1, 1};
    std::array<int64_t, 3> translation{0, 0, 0};
};

/// Refers to the bytes that it was read from. Every member throws IoError, with the offset of the
/// value, where a value is not as documented.
class VoxDictionary {
  public:
    /// Reads one from `chunk`.
    explicit VoxDictionary(ByteReader& chunk);

    /// Empty where the key is absent. Of equal keys the first counts.
    std::string_view text(std::string_view key) const;
    /// 0 where the key is absent; otherwise a decimal number in [0, largest].
    double number(std::string_view key, double largest) const;
    /// `_hidden`
    bool hidden() const;
    /// `_r` (a packed rotation) and `_t` (three integers); the identity where they are absent.
    VoxTransform transform() const;

  private:
    struct Entry {
        std::string_view key;
        std::string_view value;
        uint64_t offset_bytes = 0;  // of the value's text
    };
    const Entry* find(std::string_view key) const;
    [[noreturn]] void fail(const Entry& entry, const std::string& expected) const;

    const ByteReader& chunk_;
    std::vector<Entry> entries_;
};

/// Bytes of a file as a message may show them.
std::string printable(std::string_view text);

}  // namespace probebake
