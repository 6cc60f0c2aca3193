// What a program did to its files, as the shim wrote it down.
#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace probebake::test {

struct DiskOp {
    enum Kind : uint64_t {
        kWrite,
        kTruncate,
        kSync,  // of a file or a folder
        kCreate,
        kRename,
        kUnlink,
        kMakeFolder,
        kAck,  // a promise: `data` says which
    };
    Kind kind = kWrite;
    std::string path;
    std::string to;
    uint64_t offset = 0;  // of a truncation: the size
    std::string data;
};

inline std::string write_disk_op(const DiskOp& op) {
    std::string bytes;
    for (const uint64_t number : {uint64_t{op.kind}, uint64_t{op.path.size()},
                                  uint64_t{op.to.size()}, op.offset, uint64_t{op.data.size()}}) {
        bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
    }
    return bytes + op.path + op.to + op.data;
}

inline std::vector<DiskOp> read_disk_log(std::string_view bytes) {
    std::vector<DiskOp> ops;
    const auto take = [&](size_t size) {
        if (size > bytes.size()) throw std::runtime_error("the log of the shim is cut short");
        const std::string_view part = bytes.substr(0, size);
        bytes.remove_prefix(size);
        return part;
    };
    const auto number = [&] {
        uint64_t value = 0;
        std::memcpy(&value, take(sizeof(value)).data(), sizeof(value));
        return value;
    };
    while (!bytes.empty()) {
        DiskOp op;
        op.kind = static_cast<DiskOp::Kind>(number());
        const uint64_t path = number();
        const uint64_t to = number();
        op.offset = number();
        const uint64_t data = number();
        op.path = take(path);
        op.to = take(to);
        op.data = take(data);
        ops.push_back(std::move(op));
    }
    return ops;
}

}  // namespace probebake::test
