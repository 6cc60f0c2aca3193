#include "io/json.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace probebake {
namespace {

/// nlohmann's SAX callbacks: counts, and refuses what the document parser would let pass.
class Scan : public nlohmann::json_sax<Json> {
  public:
    explicit Scan(const JsonLimits& limits) : limits_(limits) {}

    bool null() override { return count(); }
    bool boolean(bool) override { return count(); }
    bool number_integer(number_integer_t) override { return count(); }
    bool number_unsigned(number_unsigned_t) override { return count(); }
    bool number_float(number_float_t value, const string_t& text) override {
        if (!std::isfinite(value)) return refuse("the number " + text + " is out of range");
        return count();
    }
    bool string(string_t&) override { return count(); }
    bool binary(binary_t&) override { return refuse("binary values are not JSON"); }
    bool start_object(std::size_t) override {
        keys_.emplace_back();
        return open();
    }
    bool key(string_t& key) override {
        if (!keys_.back().insert(key).second) return refuse("the key \"" + key + "\" is repeated");
        return true;
    }
    bool end_object() override {
        keys_.pop_back();
        return close();
    }
    bool start_array(std::size_t) override { return open(); }
    bool end_array() override { return close(); }
    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::detail::exception& error) override {
        // Identifiers 1xx are syntax errors, 406 a number beyond the range of double.
        return refuse(error.id == 406 ? "a number is out of range"
                                      : "not JSON at byte " + std::to_string(position));
    }

    const std::string& problem() const { return problem_; }

  private:
    bool count() {
        if (++values_ > limits_.max_values) {
            return refuse("more than " + std::to_string(limits_.max_values) + " values");
        }
        return true;
    }
    bool open() {
        if (++depth_ > limits_.max_depth) {
            return refuse("nested deeper than " + std::to_string(limits_.max_depth));
        }
        return count();
    }
    bool close() {
        --depth_;
        return true;
    }
    bool refuse(std::string problem) {
        problem_ = std::move(problem);
        return false;
    }

    JsonLimits limits_;
    uint64_t values_ = 0;
    int depth_ = 0;
    std::vector<std::set<std::string>> keys_;
    std::string problem_;
};

/// The fewest digits that read back as the same number.
std::string text_of(double x) {
    std::array<char, 32> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), x).ptr;
    return {buffer.data(), end};
}

std::string describe(const NumberRange& range) {
    const bool below = std::isfinite(range.min);
    const bool above = std::isfinite(range.max);
    const std::string lower =
        (range.more_than_min ? "more than " : "at least ") + text_of(range.min);
    if (below && above) return "a number of " + lower + " and at most " + text_of(range.max);
    if (below) return "a number of " + lower;
    if (above) return "a number of at most " + text_of(range.max);
    return "a finite number";
}

bool within(double x, const NumberRange& range) {
    return std::isfinite(x) && x <= range.max &&
           (range.more_than_min ? x > range.min : x >= range.min);
}

/// RFC 6901: ~ and / are escaped.
std::string escape(std::string_view key) {
    std::string out;
    for (const char c : key) {
        if (c == '~') {
            out += "~0";
        } else if (c == '/') {
            out += "~1";
        } else {
            out += c;
        }
    }
    return out;
}

constexpr const char* kNameRule =
    "a name of 1 to 64 characters: lower-case letters, digits, '.', '_' and '-', beginning with a "
    "letter or digit";

}  // namespace

Json parse_json(std::string_view text, const JsonLimits& limits) {
    Scan scan(limits);
    if (!Json::sax_parse(text, &scan)) {
        throw SpecError(SpecError::Kind::kMalformed, "", scan.problem());
    }
    return Json::parse(text);
}

std::string dump_json(const Json& value, int indent) {
    return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

void JsonIssues::throw_if_any() const {
    if (issues_.empty()) return;
    throw SpecError(malformed_ ? SpecError::Kind::kMalformed : SpecError::Kind::kUnacceptable,
                    issues_);
}

ObjectReader::ObjectReader(const Json& value, std::string pointer, JsonIssues& issues)
    : value_(value), pointer_(std::move(pointer)), issues_(issues) {
    if (!value_.is_object() && !value_.is_null()) {
        issues_.malformed(pointer_, "expected an object");
    }
}

std::string ObjectReader::pointer_to(std::string_view key) const {
    return pointer_ + "/" + escape(key);
}

bool ObjectReader::has(std::string_view key) const {
    return value_.is_object() && value_.contains(key);
}

const Json* ObjectReader::find(std::string_view key, bool required) {
    known_.emplace(key);
    if (value_.is_object()) {
        const auto at = value_.find(key);
        if (at != value_.end()) return &*at;
    }
    if (required) issues_.malformed(pointer_to(key), "is required");
    return nullptr;
}

std::optional<double> ObjectReader::optional_number(std::string_view key,
                                                    const NumberRange& range) {
    const Json* field = find(key, false);
    if (field == nullptr) return std::nullopt;
    if (!field->is_number()) {
        issues_.malformed(pointer_to(key), "expected " + describe(range));
        return std::nullopt;
    }
    const auto x = field->get<double>();
    if (!within(x, range)) {
        issues_.unacceptable(pointer_to(key), "is " + text_of(x) + ", expected " + describe(range));
        return std::nullopt;
    }
    return x;
}

double ObjectReader::number(std::string_view key, const NumberRange& range,
                            std::optional<double> fallback) {
    if (!fallback) find(key, true);
    const std::optional<double> x = optional_number(key, range);
    return x ? *x : fallback.value_or(std::isfinite(range.min) ? range.min : 0.0);
}

int64_t ObjectReader::integer(std::string_view key, int64_t min, int64_t max,
                              std::optional<int64_t> fallback) {
    const int64_t otherwise = fallback.value_or(min);
    const Json* field = find(key, !fallback);
    if (field == nullptr) return otherwise;
    const std::string expected =
        "expected an integer from " + std::to_string(min) + " to " + std::to_string(max);
    if (!field->is_number_integer()) {
        issues_.malformed(pointer_to(key), expected);
        return otherwise;
    }
    const bool too_big =
        field->is_number_unsigned() &&
        field->get<uint64_t>() > static_cast<uint64_t>(std::numeric_limits<int64_t>::max());
    const int64_t x = too_big ? 0 : field->get<int64_t>();
    if (too_big || x < min || x > max) {
        issues_.unacceptable(pointer_to(key), "is " + field->dump() + ", " + expected);
        return otherwise;
    }
    return x;
}

uint64_t ObjectReader::unsigned_integer(std::string_view key, uint64_t max,
                                        std::optional<uint64_t> fallback) {
    const uint64_t otherwise = fallback.value_or(0);
    const Json* field = find(key, !fallback);
    if (field == nullptr) return otherwise;
    const std::string expected = "expected an integer from 0 to " + std::to_string(max);
    if (!field->is_number_integer()) {
        issues_.malformed(pointer_to(key), expected);
        return otherwise;
    }
    const bool negative = !field->is_number_unsigned() && field->get<int64_t>() < 0;
    if (negative || field->get<uint64_t>() > max) {
        issues_.unacceptable(pointer_to(key), "is " + field->dump() + ", " + expected);
        return otherwise;
    }
    return field->get<uint64_t>();
}

bool ObjectReader::boolean(std::string_view key, bool fallback) {
    const Json* field = find(key, false);
    if (field == nullptr) return fallback;
    if (!field->is_boolean()) {
        issues_.malformed(pointer_to(key), "expected true or false");
        return fallback;
    }
    return field->get<bool>();
}

std::string ObjectReader::string(std::string_view key, size_t max_bytes,
                                 const std::optional<std::string>& fallback) {
    const Json* field = find(key, !fallback);
    if (field == nullptr) return fallback.value_or("");
    if (!field->is_string() || field->get_ref<const std::string&>().size() > max_bytes) {
        issues_.malformed(pointer_to(key),
                          "expected a string of at most " + std::to_string(max_bytes) + " bytes");
        return fallback.value_or("");
    }
    return field->get<std::string>();
}

bool is_name(std::string_view text) {
    const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
    return !text.empty() && text.size() <= 64 && plain(text[0]) &&
           std::all_of(text.begin(), text.end(),
                       [&](char c) { return plain(c) || c == '.' || c == '_' || c == '-'; });
}

std::string read_name(const Json& value, const std::string& pointer, JsonIssues& issues) {
    if (!value.is_string() || !is_name(value.get_ref<const std::string&>())) {
        issues.malformed(pointer, std::string("expected ") + kNameRule);
        return "invalid";
    }
    return value.get<std::string>();
}

std::string ObjectReader::name(std::string_view key, const std::optional<std::string>& fallback) {
    const Json* field = find(key, !fallback);
    if (field == nullptr) return fallback.value_or("invalid");
    return read_name(*field, pointer_to(key), issues_);
}

Vec3 ObjectReader::vector(std::string_view key, double max_abs, std::optional<Vec3> fallback) {
    const Json* field = find(key, !fallback);
    Vec3 v = fallback.value_or(Vec3(0.0));
    if (field == nullptr) return v;
    const NumberRange range{-max_abs, max_abs};
    if (!field->is_array() || field->size() != 3) {
        issues_.malformed(pointer_to(key), "expected an array of three numbers");
        return v;
    }
    for (int axis = 0; axis < 3; ++axis) {
        const Json& part = (*field)[static_cast<size_t>(axis)];
        const std::string pointer = pointer_to(key) + "/" + std::to_string(axis);
        if (!part.is_number()) {
            issues_.malformed(pointer, "expected " + describe(range));
        } else if (!within(part.get<double>(), range)) {
            issues_.unacceptable(
                pointer, "is " + text_of(part.get<double>()) + ", expected " + describe(range));
        } else {
            v[axis] = part.get<double>();
        }
    }
    return v;
}

size_t ObjectReader::choice(std::string_view key, std::span<const std::string_view> choices,
                            std::optional<size_t> fallback) {
    const Json* field = find(key, !fallback);
    if (field == nullptr) return fallback.value_or(0);
    if (field->is_string()) {
        const auto at = std::find(choices.begin(), choices.end(),
                                  std::string_view(field->get_ref<const std::string&>()));
        if (at != choices.end()) return static_cast<size_t>(at - choices.begin());
    }
    std::string expected;
    for (const std::string_view choice : choices) {
        expected += (expected.empty() ? "\"" : ", \"") + std::string(choice) + "\"";
    }
    issues_.malformed(pointer_to(key), "expected one of " + expected);
    return fallback.value_or(0);
}

ObjectReader ObjectReader::object(std::string_view key) {
    static const Json kEmpty = Json::object();
    const Json* field = find(key, false);
    // An explicit null is no object.
    if (field != nullptr && field->is_null()) {
        issues_.malformed(pointer_to(key), "expected an object");
        field = nullptr;
    }
    return {field == nullptr ? kEmpty : *field, pointer_to(key), issues_};
}

std::vector<ObjectReader::Element> ObjectReader::array(std::string_view key, size_t max_elements) {
    const Json* field = find(key, false);
    if (field == nullptr) return {};
    if (!field->is_array()) {
        issues_.malformed(pointer_to(key), "expected an array");
        return {};
    }
    if (field->size() > max_elements) {
        issues_.unacceptable(pointer_to(key), "has " + std::to_string(field->size()) +
                                                  " elements, expected at most " +
                                                  std::to_string(max_elements));
        return {};
    }
    std::vector<Element> elements;
    for (size_t i = 0; i < field->size(); ++i) {
        elements.push_back({&(*field)[i], pointer_to(key) + "/" + std::to_string(i)});
    }
    return elements;
}

void ObjectReader::refuse_unknown() {
    if (!value_.is_object()) return;
    for (const auto& [key, field] : value_.items()) {
        if (known_.contains(key)) continue;
        std::string known;
        for (const std::string& name : known_) known += (known.empty() ? "" : ", ") + name;
        issues_.malformed(pointer_to(key), "is unknown, expected only: " + known);
    }
}

}  // namespace probebake
