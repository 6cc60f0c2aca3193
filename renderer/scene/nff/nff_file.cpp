#include "scene/nff/nff_file.h"

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "io/file.h"

namespace probebake {
namespace {

constexpr uint64_t kMostBytes = uint64_t{1} << 32;

/// Words of the text and the lines they stand in.
class Words {
  public:
    Words(std::string_view text, const std::string& file) : text_(text), file_(file) { advance(); }

    bool done() const { return word_.empty(); }
    std::string_view peek() const { return word_; }
    int line() const { return line_; }
    std::string_view next() {
        const std::string_view word = word_;
        advance();
        return word;
    }

    [[noreturn]] void fail_at(int line, const std::string& problem) const {
        throw IoError(file_, "line " + std::to_string(line) + ": " + problem);
    }
    [[noreturn]] void fail_expected(const std::string& what) const {
        fail_at(line_, "expected " + what + ", not " + shown());
    }

    double number(const char* what) {
        double value = 0.0;
        const char* end = word_.data() + word_.size();
        const auto [rest, error] = std::from_chars(word_.data(), end, value);
        if (done() || error != std::errc() || rest != end || !std::isfinite(value)) {
            fail_expected(std::string(what) + ", a finite number");
        }
        next();
        return value;
    }
    /// From `least` on.
    int count(const char* what, int least) {
        int value = 0;
        const char* end = word_.data() + word_.size();
        const auto [rest, error] = std::from_chars(word_.data(), end, value);
        if (done() || error != std::errc() || rest != end || value < least) {
            fail_expected(std::string(what) + ", a whole number from " + std::to_string(least) +
                          " on");
        }
        next();
        return value;
    }
    Vec3 vector(const char* what) {
        Vec3 v;
        for (int axis = 0; axis < 3; ++axis) v[axis] = number(what);
        return v;
    }
    Rgb color(const char* what) {
        const int line = line_;
        const Rgb rgb(vector(what));
        if (!is_finite(Vec3(rgb))) fail_at(line, std::string(what) + ": too large a number");
        return rgb;
    }
    bool number_follows() const {
        double value = 0.0;
        return !done() &&
               std::from_chars(word_.data(), word_.data() + word_.size(), value).ec == std::errc();
    }

  private:
    static bool is_space(char c) {
        return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
    }
    void advance() {
        for (;;) {
            while (at_ < text_.size() && is_space(text_[at_])) {
                if (text_[at_++] == '\n') ++at_line_;
            }
            if (at_ >= text_.size() || text_[at_] != '#') break;
            while (at_ < text_.size() && text_[at_] != '\n') ++at_;
        }
        const size_t begin = at_;
        while (at_ < text_.size() && !is_space(text_[at_]) && text_[at_] != '#') ++at_;
        word_ = text_.substr(begin, at_ - begin);
        line_ = at_line_;
    }
    std::string shown() const {
        if (done()) return "the end of the file";
        constexpr size_t kMostShown = 40;
        std::string text = "\"";
        for (const char c : word_.substr(0, kMostShown)) {
            text += c >= ' ' && c <= '~' ? c : '?';
        }
        return text + (word_.size() > kMostShown ? "…\"" : "\"");
    }

    std::string_view text_;
    const std::string& file_;
    size_t at_ = 0;
    int at_line_ = 1;
    std::string_view word_;
    int line_ = 1;
};

class Reader {
  public:
    Reader(std::string_view text, const std::string& file) : words_(text, file) {}

    NffScene read() {
        while (!words_.done()) statement();
        return std::move(scene_);
    }

  private:
    void statement() {
        statement_line_ = words_.line();
        const std::string_view word = words_.peek();
        if (word == "v") {
            words_.next();
            view();
        } else if (word == "b") {
            words_.next();
            scene_.background = words_.color("red, green and blue of the background");
        } else if (word == "l") {
            words_.next();
            light();
        } else if (word == "f") {
            words_.next();
            material();
        } else if (word == "c") {
            before_object();
            cone();
        } else if (word == "s") {
            before_object();
            sphere();
        } else if (word == "p" || word == "pp") {
            before_object();
            polygon(word == "pp");
        } else {
            words_.fail_expected("a statement: v, b, l, f, c, s, p or pp");
        }
    }

    void view() {
        if (scene_.view) words_.fail_at(statement_line_, "expected one view, not a second");
        if (scene_.shapes.size() > 0) {
            words_.fail_at(statement_line_, "expected the view before the first object");
        }
        NffView view;
        uint32_t seen = 0;
        constexpr const char* kParts[] = {"from", "at", "up", "angle", "hither", "resolution"};
        for (size_t i = 0; i < std::size(kParts); ++i) {
            uint32_t part = 0;
            while (part < std::size(kParts) && words_.peek() != kParts[part]) ++part;
            if (part == std::size(kParts) || (seen >> part & 1u) != 0) {
                std::string missing;
                for (uint32_t k = 0; k < std::size(kParts); ++k) {
                    if ((seen >> k & 1u) != 0) continue;
                    missing += (missing.empty() ? "" : ", ") + std::string(kParts[k]);
                }
                words_.fail_expected("of the view: " + missing);
            }
            seen |= 1u << part;
            words_.next();
            switch (part) {
                case 0:
                    view.from = words_.vector("x, y, z of from");
                    break;
                case 1:
                    view.at = words_.vector("x, y, z of at");
                    break;
                case 2:
                    view.up = words_.vector("x, y, z of up");
                    break;
                case 3:
                    view.angle_deg = words_.number("an angle in degrees");
                    break;
                case 4:
                    view.hither = words_.number("the distance of the hither plane");
                    break;
                default:
                    view.width_px = words_.count("the width in pixels", 1);
                    view.height_px = words_.count("the height in pixels", 1);
            }
        }
        scene_.view = view;
    }

    void light() {
        if (scene_.shapes.size() > 0) {
            words_.fail_at(statement_line_, "expected lights before the first object");
        }
        NffLight light{.position = words_.vector("x, y, z of a light"), .color = std::nullopt};
        if (words_.number_follows()) {
            light.color = words_.color("red, green and blue of a light");
        }
        scene_.lights.push_back(light);
    }

    void material() {
        NffMaterial m;
        m.color = words_.color("red, green and blue of a material");
        m.diffuse = words_.number("Kd");
        m.specular = words_.number("Ks");
        m.shine = words_.number("Shine");
        m.transmittance = words_.number("T");
        m.refraction_index = words_.number("the index of refraction");
        scene_.materials.push_back(m);
    }

    void before_object() {
        if (scene_.materials.empty()) {
            words_.fail_at(statement_line_, "expected a material (f) before the first object");
        }
        words_.next();
    }

    template <class Add>
    void add_object(NffObject object, Add add) {
        object.material = static_cast<uint32_t>(scene_.materials.size() - 1);
        try {
            add();
        } catch (const std::invalid_argument& error) {
            words_.fail_at(statement_line_, error.what());
        }
        scene_.objects.push_back(object);
    }

    void sphere() {
        const Vec3 center = words_.vector("x, y, z of a sphere's centre");
        const double radius = words_.number("a sphere's radius");
        add_object({.inward = std::signbit(radius)}, [&] {
            scene_.shapes.add(Sphere{center, std::abs(radius)});
        });
    }

    void cone() {
        Cone cone;
        cone.base = words_.vector("x, y, z of a cone's base");
        cone.base_radius = words_.number("the radius of a cone's base");
        cone.apex = words_.vector("x, y, z of a cone's apex");
        cone.apex_radius = words_.number("the radius of a cone's apex");
        const bool inward = cone.base_radius < 0.0 || cone.apex_radius < 0.0;
        if (inward && (cone.base_radius > 0.0 || cone.apex_radius > 0.0)) {
            words_.fail_at(statement_line_, "cone: expected two radii of one sign");
        }
        cone.base_radius = std::abs(cone.base_radius);
        cone.apex_radius = std::abs(cone.apex_radius);
        add_object({.inward = inward}, [&] { scene_.shapes.add(cone); });
    }

    void polygon(bool with_normals) {
        const int count = words_.count("a polygon's number of vertices", 3);
        std::vector<Vec3> vertices;
        std::vector<Vec3> normals;
        for (int i = 0; i < count; ++i) {
            vertices.push_back(words_.vector("x, y, z of a vertex"));
            if (with_normals) normals.push_back(words_.vector("x, y, z of a normal"));
        }
        NffObject object;
        if (with_normals) object.first_normal = static_cast<uint32_t>(scene_.normals.size());
        add_object(object, [&] { scene_.shapes.add_polygon(vertices); });
        scene_.normals.insert(scene_.normals.end(), normals.begin(), normals.end());
    }

    Words words_;
    NffScene scene_;
    int statement_line_ = 1;
};

}  // namespace

NffScene parse_nff(std::string_view text, const std::string& file) {
    return Reader(text, file).read();
}

NffScene read_nff(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = read_file(path, kMostBytes);
    return parse_nff({reinterpret_cast<const char*>(bytes.data()), bytes.size()},
                     path.filename().string());
}

}  // namespace probebake
