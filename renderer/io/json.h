// Strict reading of JSON that somebody else wrote.
//
// parse_json scans before it parses: depth, number of values, duplicate keys. ObjectReader then
// reads field by field through checked getters that know their JSON pointer; nothing converts
// silently (64.7 is no integer, −1 no unsigned, 1e300 no int). Problems are collected, so that a
// client sees all of them at once; the values read in the meantime are defaults and must not be
// used before JsonIssues::throw_if_any.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "io/spec_error.h"
#include "math/vec.h"

namespace probebake {

using Json = nlohmann::json;

struct JsonLimits {
    int max_depth = 16;
    uint64_t max_values = 1'000'000;
};

/// Throws SpecError (malformed) with the byte offset for anything that is not one JSON document in
/// UTF-8 within the limits, for a repeated key and for a number beyond the range of double.
Json parse_json(std::string_view text, const JsonLimits& limits = {});

/// One line, invalid UTF-8 replaced; never throws.
std::string dump_json(const Json& value, int indent = -1);

class JsonIssues {
  public:
    void malformed(std::string pointer, std::string detail) {
        malformed_ = true;
        add(std::move(pointer), std::move(detail));
    }
    void unacceptable(std::string pointer, std::string detail) {
        add(std::move(pointer), std::move(detail));
    }
    bool empty() const { return issues_.empty(); }
    /// Throws SpecError with all of them; malformed if any is.
    void throw_if_any() const;

  private:
    static constexpr size_t kMaxIssues = 32;  // enough to mend a document, not a flood
    void add(std::string pointer, std::string detail) {
        if (issues_.size() < kMaxIssues) issues_.push_back({std::move(pointer), std::move(detail)});
    }

    bool malformed_ = false;
    std::vector<SpecIssue> issues_;
};

/// A closed or half-open range of numbers; "more_than" excludes the lower end.
struct NumberRange {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool more_than_min = false;
};

class ObjectReader {
  public:
    /// `value` outlives the reader. Anything but an object is an issue, then read as an empty one.
    ObjectReader(const Json& value, std::string pointer, JsonIssues& issues);

    bool has(std::string_view key) const;
    /// Every getter marks its field as known. Without a fallback the field is required.
    std::optional<double> optional_number(std::string_view key, const NumberRange& range);
    double number(std::string_view key, const NumberRange& range, std::optional<double> fallback);
    int64_t integer(std::string_view key, int64_t min, int64_t max,
                    std::optional<int64_t> fallback);
    uint64_t unsigned_integer(std::string_view key, uint64_t max, std::optional<uint64_t> fallback);
    bool boolean(std::string_view key, bool fallback);
    std::string string(std::string_view key, size_t max_bytes,
                       const std::optional<std::string>& fallback);
    /// [a-z0-9][a-z0-9._-]{0,63}
    std::string name(std::string_view key, const std::optional<std::string>& fallback);
    /// Three numbers of at most max_abs each.
    Vec3 vector(std::string_view key, double max_abs, std::optional<Vec3> fallback);
    /// Index into `choices`.
    size_t choice(std::string_view key, std::span<const std::string_view> choices,
                  std::optional<size_t> fallback);
    /// A nested object; absent: an empty one.
    ObjectReader object(std::string_view key);
    /// The elements of an array field with their pointers; absent: none.
    struct Element {
        const Json* value;
        std::string pointer;
    };
    std::vector<Element> array(std::string_view key, size_t max_elements);
    /// Reports every field that no getter asked for. The last call on a reader.
    void refuse_unknown();

    std::string pointer_to(std::string_view key) const;
    JsonIssues& issues() { return issues_; }

  private:
    /// The field, marked as known; null where absent (an issue where `required`).
    const Json* find(std::string_view key, bool required);

    const Json& value_;
    std::string pointer_;
    JsonIssues& issues_;
    std::set<std::string, std::less<>> known_;
};

/// Reads an element that must be a string of the form of ObjectReader::name.
std::string read_name(const Json& value, const std::string& pointer, JsonIssues& issues);
bool is_name(std::string_view text);

}  // namespace probebake
