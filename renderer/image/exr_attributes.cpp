#include "image/exr_attributes.h"

#include <ImfDoubleAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfIntAttribute.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>

#include "io/io_error.h"

namespace probebake {
namespace {

constexpr const char* kPosition = "probe:position";
constexpr const char* kId = "probe:id";
constexpr const char* kState = "probe:state";
constexpr const char* kNear = "probe:near";
constexpr const char* kFar = "probe:far";
constexpr const char* kUnit = "probe:unit";
constexpr const char* kSceneSha256 = "probe:sceneSha256";
constexpr const char* kSeed = "probe:seed";
constexpr const char* kValid = "probe:valid";
constexpr std::array kOwnNames = {kPosition, kId,          kState, kNear, kFar,
                                  kUnit,     kSceneSha256, kSeed,  kValid};

bool is_further_name(const std::string& name) {
    constexpr size_t kMaxLength = 255;  // Imf::Name cuts what is longer
    return name.starts_with("probe:") && name.size() <= kMaxLength &&
           name.find('\0') == std::string::npos &&
           std::find(kOwnNames.begin(), kOwnNames.end(), name) == kOwnNames.end();
}

template <class Number>
std::string to_text(Number value) {
    std::array<char, 32> buffer{};
    const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    return {buffer.data(), result.ptr};
}

/// The numbers of a text with single spaces between them; false where it is anything else.
template <class Number, size_t count>
bool parse_numbers(const std::string& text, std::array<Number, count>& numbers) {
    const char* at = text.data();
    const char* const end = at + text.size();
    for (size_t i = 0; i < count; ++i) {
        if (i > 0 && (at == end || *at++ != ' ')) return false;
        const auto result = std::from_chars(at, end, numbers[i]);
        if (result.ec != std::errc()) return false;
        at = result.ptr;
    }
    return at == end;
}

class AttributeReader {
  public:
    AttributeReader(const Imf::Header& header, const std::string& file)
        : header_(header), file_(file) {}

    /// Null where there is none of this name.
    template <class Attribute>
    const Attribute* find(const char* name) const {
        const auto at = header_.find(name);
        if (at == header_.end()) return nullptr;
        const auto* attribute = dynamic_cast<const Attribute*>(&at.attribute());
        if (attribute == nullptr) {
            fail(name, std::string("has type ") + at.attribute().typeName() + ", expected " +
                           Attribute::staticTypeName());
        }
        return attribute;
    }
    /// Leaves `value` where there is none of this name.
    template <class Attribute, class Value>
    void read(const char* name, Value& value) const {
        if (const auto* attribute = find<Attribute>(name)) value = attribute->value();
    }
    template <class Number, size_t count>
    bool read_numbers(const char* name, std::array<Number, count>& numbers) const {
        const auto* text = find<Imf::StringAttribute>(name);
        if (text != nullptr && !parse_numbers(text->value(), numbers)) {
            fail(name, "is \"" + text->value() + "\", expected " + std::to_string(count) +
                           " decimal number(s)");
        }
        return text != nullptr;
    }
    [[noreturn]] void fail(const std::string& name, const std::string& problem) const {
        throw IoError(file_, "attribute " + name + " " + problem);
    }

  private:
    const Imf::Header& header_;
    const std::string& file_;
};

/// Red, green, blue and white within the rounding of other programs' tables.
bool is_rec709(const Imf::Chromaticities& given) {
    const Imf::Chromaticities rec709;
    constexpr float kTolerance = 1e-3f;
    return given.red.equalWithAbsError(rec709.red, kTolerance) &&
           given.green.equalWithAbsError(rec709.green, kTolerance) &&
           given.blue.equalWithAbsError(rec709.blue, kTolerance) &&
           given.white.equalWithAbsError(rec709.white, kTolerance);
}

}  // namespace

Imf::Header make_cube_header(int face_size, const ProbeAttributes& attributes) {
    if (face_size < 1 || face_size > kMaxFaceSize_px) {
        throw std::invalid_argument("a cubemap file has faces of 1 to " +
                                    std::to_string(kMaxFaceSize_px) + " pixels, not " +
                                    std::to_string(face_size));
    }
    return make_header(face_size, 6 * face_size, Imf::ENVMAP_CUBE, attributes);
}

Imf::Header make_header(int width_px, int height_px, std::optional<Imf::Envmap> layout,
                        const ProbeAttributes& attributes) {
    Imf::Header header(width_px, height_px);
    if (layout) Imf::addEnvmap(header, *layout);
    Imf::addChromaticities(header, Imf::Chromaticities());
    Imf::addOwner(header, attributes.owner);
    Imf::addComments(header, attributes.comments);

    const auto add_text = [&](const std::string& name, const std::string& text) {
        header.insert(name, Imf::StringAttribute(text));
    };
    const auto add_number = [&](const std::string& name, double number) {
        header.insert(name, Imf::DoubleAttribute(number));
    };
    const Vec3& p = attributes.position_m;
    add_text(kPosition, to_text(p.x) + " " + to_text(p.y) + " " + to_text(p.z));
    add_text(kId, attributes.id);
    add_text(kState, attributes.state);
    add_number(kNear, attributes.near_m);
    add_number(kFar, attributes.far_m);
    add_text(kUnit, attributes.unit);
    add_text(kSceneSha256, attributes.scene_sha256);
    add_text(kSeed, to_text(attributes.seed));
    header.insert(kValid, Imf::IntAttribute(attributes.valid ? 1 : 0));

    const auto check_name = [&](const std::string& name) {
        if (!is_further_name(name) || header.find(name) != header.end()) {
            throw std::invalid_argument("attribute \"" + name +
                                        "\" is already written, does not begin with \"probe:\" or "
                                        "is too long");
        }
    };
    for (const auto& [name, text] : attributes.texts) {
        check_name(name);
        add_text(name, text);
    }
    for (const auto& [name, number] : attributes.numbers) {
        check_name(name);
        add_number(name, number);
    }
    return header;
}

ProbeAttributes read_cube_header(const Imf::Header& header, const std::string& file) {
    const AttributeReader reader(header, file);
    const auto* envmap = reader.find<Imf::EnvmapAttribute>("envmap");
    if (envmap == nullptr || envmap->value() != Imf::ENVMAP_CUBE) {
        throw IoError(file, "is not a cube-face environment map (attribute envmap)");
    }
    const auto* primaries = reader.find<Imf::ChromaticitiesAttribute>("chromaticities");
    if (primaries != nullptr && !is_rec709(primaries->value())) {
        throw IoError(file, "has primaries other than Rec.709 (attribute chromaticities)");
    }

    ProbeAttributes attributes;
    reader.read<Imf::StringAttribute>("owner", attributes.owner);
    reader.read<Imf::StringAttribute>("comments", attributes.comments);
    std::array<double, 3> position{};
    if (reader.read_numbers(kPosition, position)) {
        attributes.position_m = {position[0], position[1], position[2]};
    }
    reader.read<Imf::StringAttribute>(kId, attributes.id);
    reader.read<Imf::StringAttribute>(kState, attributes.state);
    reader.read<Imf::DoubleAttribute>(kNear, attributes.near_m);
    reader.read<Imf::DoubleAttribute>(kFar, attributes.far_m);
    reader.read<Imf::StringAttribute>(kUnit, attributes.unit);
    reader.read<Imf::StringAttribute>(kSceneSha256, attributes.scene_sha256);
    std::array<uint64_t, 1> seed{};
    if (reader.read_numbers(kSeed, seed)) attributes.seed = seed[0];
    if (const auto* valid = reader.find<Imf::IntAttribute>(kValid)) {
        attributes.valid = valid->value() != 0;
    }

    for (auto at = header.begin(); at != header.end(); ++at) {
        const std::string name = at.name();
        if (!is_further_name(name)) continue;
        const Imf::Attribute* attribute = &at.attribute();
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(attribute)) {
            attributes.texts[name] = text->value();
        } else if (const auto* number = dynamic_cast<const Imf::DoubleAttribute*>(attribute)) {
            attributes.numbers[name] = number->value();
        } else if (const auto* single = dynamic_cast<const Imf::FloatAttribute*>(attribute)) {
            attributes.numbers[name] = static_cast<double>(single->value());
        }
    }
    return attributes;
}

}  // namespace probebake
