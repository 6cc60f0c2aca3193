#include "io/checked_file.h"

#include <xxhash.h>

#include <array>
#include <memory>

#include "io/file.h"

namespace probebake {
namespace {

struct Header {
    std::array<char, 8> magic{};
    std::array<char, 8> kind{};
    uint64_t version = 0;
    uint64_t payload_bytes = 0;
    uint64_t checksum = 0;
};
static_assert(sizeof(Header) == 40);

constexpr std::array<char, 8> kMagic = {'P', 'R', 'B', 'B', 'A', 'K', 'E', '\n'};

std::array<char, 8> kind_bytes(std::string_view kind) {
    std::array<char, 8> bytes{};
    kind.copy(bytes.data(), bytes.size());
    return bytes;
}

}  // namespace

void write_checked_file(const std::filesystem::path& path, std::string_view kind, uint64_t version,
                        std::span<const std::span<const std::byte>> sections) {
    Header header{.magic = kMagic, .kind = kind_bytes(kind), .version = version};
    std::vector<uint64_t> sizes;
    for (const auto section : sections) sizes.push_back(section.size());

    std::vector<std::span<const std::byte>> parts{std::as_bytes(std::span(&header, 1))};
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                         &XXH3_freeState);
    XXH3_64bits_reset(state.get());
    const auto append = [&](std::span<const std::byte> part) {
        parts.push_back(part);
        header.payload_bytes += part.size();
        XXH3_64bits_update(state.get(), part.data(), part.size());
    };
    for (size_t i = 0; i < sections.size(); ++i) {
        append(std::as_bytes(std::span(&sizes[i], 1)));
        append(sections[i]);
    }
    header.checksum = XXH3_64bits_digest(state.get());
    write_file_atomically(path, parts);
}

CheckedFile::CheckedFile(const std::filesystem::path& path, std::string_view kind, uint64_t version)
    : name_(path.filename().string()), bytes_(read_file(path)) {
    ByteReader reader(name_, bytes_);
    const auto header = reader.read<Header>("the header");
    if (header.magic != kMagic) throw IoError(name_, 0, "is not a probebake cache file");
    if (header.kind != kind_bytes(kind)) {
        throw IoError(name_, 8, "is not a cache file of kind \"" + std::string(kind) + "\"");
    }
    if (header.version != version) {
        throw IoError(name_, 16,
                      "has version " + std::to_string(header.version) + ", expected " +
                          std::to_string(version));
    }
    if (header.payload_bytes != reader.remaining()) {
        throw IoError(name_, 24,
                      "holds " + std::to_string(reader.remaining()) +
                          " bytes after the header, expected " +
                          std::to_string(header.payload_bytes));
    }
    const std::span<const std::byte> payload = std::span(bytes_).subspan(sizeof(Header));
    if (XXH3_64bits(payload.data(), payload.size()) != header.checksum) {
        throw IoError(name_, 32, "is damaged: the checksum does not match");
    }
    while (!reader.done()) {
        const auto size = reader.read<uint64_t>("the size of a section");
        sections_.push_back(reader.take(size, "a section"));
    }
}

std::span<const std::byte> CheckedFile::section(size_t i) const {
    if (i >= sections_.size()) {
        throw IoError(name_, "has " + std::to_string(sections_.size()) + " sections, no section " +
                                 std::to_string(i));
    }
    return sections_[i];
}

}  // namespace probebake
