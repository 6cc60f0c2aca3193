// A file that a bake made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/sha256.h"

namespace probebake {

/// Ready to be stored.
struct ProductFile {
    std::string name;  // "cube.exr", "sh.json"
    std::vector<std::byte> bytes;
    uint64_t size_bytes = 0;  // known when the bytes are given away, too
    std::string sha256;
};

inline ProductFile make_product_file(std::string name, std::vector<std::byte> bytes) {
    std::string sha256 = sha256_hex(bytes);
    const uint64_t size_bytes = bytes.size();
    return {std::move(name), std::move(bytes), size_bytes, std::move(sha256)};
}

}  // namespace probebake
