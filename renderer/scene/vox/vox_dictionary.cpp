#include "scene/vox/vox_dictionary.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace probebake {
namespace {

/// MagicaVoxel writes a dozen; ogt_vox.h of opengametools has the same limit.
constexpr uint32_t kMaxPairs = 256;

/// The number that is the whole of `text`, if it is one.
template <class T>
std::optional<T> parse_number(std::string_view text) {
    T value{};
    const char* end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || stopped != end) return std::nullopt;
    return value;
}

/// ROTATION: bits 0-1 and 2-3 are the columns of the nonzero entries of rows 0 and 1, bits 4-6 the
/// signs of the rows (1: negative).
bool unpack_rotation(std::string_view text, VoxTransform& out) {
    const int bits = parse_number<int>(text).value_or(-1);
    const auto first = static_cast<size_t>(bits & 3);
    const auto second = static_cast<size_t>((bits >> 2) & 3);
    if (bits < 0 || bits > 127 || first == 3 || second == 3 || first == second) return false;
    out.axis = {first, second, 3 - first - second};
    for (size_t row = 0; row < 3; ++row) out.sign[row] = ((bits >> (4 + row)) & 1) != 0 ? -1 : 1;
    return true;
}

bool parse_translation(std::string_view text, VoxTransform& out) {
    for (size_t row = 0; row < 3; ++row) {
        const size_t end = row < 2 ? text.find(' ') : text.size();
        if (end == std::string_view::npos) return false;
        const auto value = parse_number<int32_t>(text.substr(0, end));
        if (!value) return false;
        out.translation[row] = *value;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return true;
}

std::string_view read_string(ByteReader& chunk, const char* what) {
    return chunk.take_text(chunk.read<uint32_t>("the length of a string"), what);
}

}  // namespace

VoxDictionary::VoxDictionary(ByteReader& chunk) : chunk_(chunk) {
    const uint64_t at = chunk.offset();
    const auto count = chunk.read<uint32_t>("the size of a dictionary");
    if (count > kMaxPairs) {
        chunk.fail_at(at, "a dictionary has " + std::to_string(count) +
                              " pairs, expected at most " + std::to_string(kMaxPairs));
    }
    for (uint32_t i = 0; i < count; ++i) {
        Entry entry;
        entry.key = read_string(chunk, "a key");
        entry.value = read_string(chunk, "a value");
        entry.offset_bytes = chunk.offset() - entry.value.size();
        entries_.push_back(entry);
    }
}

const VoxDictionary::Entry* VoxDictionary::find(std::string_view key) const {
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& entry) { return entry.key == key; });
    return found == entries_.end() ? nullptr : &*found;
}

std::string_view VoxDictionary::text(std::string_view key) const {
    const Entry* entry = find(key);
    return entry == nullptr ? std::string_view{} : entry->value;
}

double VoxDictionary::number(std::string_view key, double largest) const {
    const Entry* entry = find(key);
    if (entry == nullptr) return 0.0;
    const auto value = parse_number<double>(entry->value);
    if (!value || !(*value >= 0.0 && *value <= largest)) {
        fail(*entry, "a number from 0 to " + std::to_string(static_cast<int64_t>(largest)));
    }
    return *value;
}

bool VoxDictionary::hidden() const {
    const Entry* entry = find("_hidden");
    if (entry == nullptr || entry->value == "0") return false;
    if (entry->value != "1") fail(*entry, "0 or 1");
    return true;
}

VoxTransform VoxDictionary::transform() const {
    VoxTransform transform;
    const Entry* rotation = find("_r");
    if (rotation != nullptr && !unpack_rotation(rotation->value, transform)) {
        fail(*rotation, "a rotation packed into a number from 0 to 127");
    }
    const Entry* translation = find("_t");
    if (translation != nullptr && !parse_translation(translation->value, transform)) {
        fail(*translation, "three integers of 32 bits");
    }
    return transform;
}

void VoxDictionary::fail(const Entry& entry, const std::string& expected) const {
    chunk_.fail_at(entry.offset_bytes, printable(entry.key) + " is \"" + printable(entry.value) +
                                           "\", expected " + expected);
}

std::string printable(std::string_view text) {
    constexpr size_t kLongest = 32;
    std::string shown;
    for (const char c : text.substr(0, kLongest)) shown += c >= ' ' && c <= '~' ? c : '?';
    return text.size() > kLongest ? shown + "..." : shown;
}

}  // namespace probebake
