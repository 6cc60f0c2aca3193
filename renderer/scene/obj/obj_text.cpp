#include "scene/obj/obj_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

namespace probebake {
namespace {

constexpr std::string_view kSpace = " \t";

/// One line after the other, without its end and space around it.
class Lines {
  public:
    Lines(std::string_view text, const std::string& file) : text_(text), file_(file) {
        constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
        if (text_.starts_with(kByteOrderMark)) text_.remove_prefix(kByteOrderMark.size());
    }

    bool next() {
        if (at_ >= text_.size()) return false;
        const size_t end = std::min(text_.find_first_of("\r\n", at_), text_.size());
        rest_ = text_.substr(at_, end - at_);
        at_ = end + (text_.substr(end, 2) == "\r\n" ? 2 : 1);
        ++line_;
        trim();
        return true;
    }
    /// Names may hold a '#', numbers do not.
    void cut_comment() {
        rest_ = rest_.substr(0, rest_.find('#'));
        trim();
    }
    uint64_t line() const { return line_; }

    /// The next word of the line; empty at its end.
    std::string_view word() {
        const size_t end = std::min(rest_.find_first_of(kSpace), rest_.size());
        const std::string_view word = rest_.substr(0, end);
        rest_.remove_prefix(end);
        skip_space();
        return word;
    }
    std::string_view rest() const { return rest_; }

    [[noreturn]] void fail(uint64_t line, const std::string& problem) const {
        throw IoError(file_, "line " + std::to_string(line) + ": " + problem);
    }
    [[noreturn]] void fail_expected(const char* what, std::string_view word) const {
        fail(line_, std::string("expected ") + what +
                        (word.empty() ? ", not the end of the line"
                                      : ", not \"" + std::string(word.substr(0, 40)) + "\""));
    }
    double number(const char* what) {
        const std::string_view text = word();
        const std::optional<double> value = number_of(text);
        if (!value) fail_expected(what, text);
        return *value;
    }
    /// A finite number in a form that tinyobjloader reads as well, too.
    static std::optional<double> number_of(std::string_view text) {
        if (text.starts_with('+')) text.remove_prefix(1);
        constexpr size_t kMaxDigits = 64;
        if (text.size() > kMaxDigits || text.starts_with('+') || !has_usual_exponent(text)) {
            return std::nullopt;
        }
        double value = 0.0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
            return std::nullopt;
        }
        return value;
    }

  private:
    /// Beyond it tinyobjloader's power of ten is infinite, and 0 times that no number.
    static bool has_usual_exponent(std::string_view text) {
        const size_t e = text.find_first_of("eE");
        if (e == std::string_view::npos) return true;
        text.remove_prefix(e + 1);
        if (text.starts_with('+')) text.remove_prefix(1);
        int exponent = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), exponent);
        return error == std::errc() && end == text.data() + text.size() &&
               std::abs(exponent) <= std::numeric_limits<double>::max_exponent10;
    }

    void trim() {
        skip_space();
        rest_.remove_suffix(rest_.size() - (rest_.find_last_not_of(kSpace) + 1));
    }
    void skip_space() {
        rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
    }

    std::string_view text_;
    const std::string& file_;
    size_t at_ = 0;
    uint64_t line_ = 0;
    std::string_view rest_;
};

/// The largest index of one kind, and where it stands: faces may refer to what follows them.
struct Indices {
    const char* of;
    uint64_t largest = 0;
    uint64_t line = 0;

    void take(std::string_view text, uint64_t count, const Lines& lines) {
        int index = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
        if (error != std::errc() || end != text.data() + text.size() || index == 0) {
            lines.fail_expected("an index from 1 on, or below 0", text);
        }
        if (index < 0) {
            if (static_cast<uint64_t>(-int64_t{index}) > count) {
                lines.fail(lines.line(), "index " + std::string(text) + ", but only " +
                                             std::to_string(count) + " " + of + " before it");
            }
        } else if (static_cast<uint64_t>(index) > largest) {
            largest = static_cast<uint64_t>(index);
            line = lines.line();
        }
    }
    void require(uint64_t count, const Lines& lines) const {
        if (largest > count) {
            lines.fail(line, "index " + std::to_string(largest) + ", but the file has " +
                                 std::to_string(count) + " " + of);
        }
    }
};

class ObjCheck {
  public:
    ObjCheck(std::string_view text, const MeshLimits& limits, const std::string& file)
        : lines_(text, file), limits_(limits), file_(file) {}

    ObjText run() {
        while (lines_.next()) statement(lines_.word());
        positions_.require(found_.vertices, lines_);
        coordinates_.require(found_.texture_coordinates, lines_);
        return std::move(found_);
    }

  private:
    void statement(std::string_view name) {
        if (name == "v") {
            vertex();
        } else if (name == "vt") {
            texture_coordinate();
        } else if (name == "f") {
            face();
        } else if (name == "usemtl") {
            if (lines_.rest().empty()) lines_.fail_expected("the name of a material", "");
            found_.text += "usemtl " + std::string(lines_.rest()) + "\n";
        } else if (name == "mtllib") {
            if (!lines_.rest().empty()) found_.material_files.emplace_back(lines_.rest());
        } else if (name == "l" || name == "p" || name == "curv" || name == "surf") {
            found_.has_others = true;
        }
    }
    void vertex() {
        lines_.cut_comment();
        require_vertices(++found_.vertices, limits_, file_);
        found_.text += "v";
        for (int i = 0; i < 3; ++i) copy_number("a coordinate, a finite number");
        found_.text += '\n';
        if (lines_.rest().find_first_of(kSpace) != std::string_view::npos) found_.has_colors = true;
    }
    void texture_coordinate() {
        lines_.cut_comment();
        require_vertices(++found_.texture_coordinates, limits_, file_);
        found_.text += "vt";
        copy_number("a texture coordinate, a finite number");
        if (!lines_.rest().empty()) copy_number("a texture coordinate, a finite number");
        found_.text += '\n';
    }
    void face() {
        lines_.cut_comment();
        found_.text += 'f';
        uint64_t corners = 0;
        for (std::string_view word = lines_.word(); !word.empty(); word = lines_.word()) {
            corner(word);
            ++corners;
        }
        found_.text += '\n';
        if (corners < 3) lines_.fail_expected("three corners of a face or more", "");
        found_.triangles += corners - 2;
        require_triangles(found_.triangles, limits_, file_);
    }
    /// v, v/vt, v//vn or v/vt/vn; normals are passed over.
    void corner(std::string_view word) {
        const size_t slash = std::min(word.find('/'), word.size());
        positions_.take(word.substr(0, slash), found_.vertices, lines_);
        found_.text += ' ';
        found_.text += word.substr(0, slash);
        if (slash == word.size()) return;
        const std::string_view rest = word.substr(slash + 1);
        const size_t second = std::min(rest.find('/'), rest.size());
        if (second == 0) return;
        coordinates_.take(rest.substr(0, second), found_.texture_coordinates, lines_);
        found_.text += '/';
        found_.text += rest.substr(0, second);
    }
    void copy_number(const char* what) {
        const std::string_view text = lines_.rest().substr(0, lines_.rest().find_first_of(kSpace));
        lines_.number(what);
        found_.text += ' ';
        found_.text += text;
    }

    Lines lines_;
    const MeshLimits& limits_;
    const std::string& file_;
    ObjText found_;
    Indices positions_{"vertices"};
    Indices coordinates_{"texture coordinates"};
};

/// The name of a map statement's file, and whether it is clamped; other options are noted.
void map_statement(std::string_view name, Lines& lines, MtlText& found) {
    bool clamp = false;
    while (lines.rest().starts_with('-')) {
        const std::string_view option = lines.word();
        int most = 1;
        if (option == "-o" || option == "-s" || option == "-t") most = 3;
        if (option == "-mm") most = 2;
        if (option == "-clamp") {
            clamp = lines.word() == "on";
            continue;
        }
        found.has_options = true;
        if (most == 1) lines.word();  // a number or a word
        for (int i = 0; most > 1 && i < most; ++i) {
            const std::string_view next =
                lines.rest().substr(0, lines.rest().find_first_of(kSpace));
            if (!Lines::number_of(next)) break;  // fewer than it may have
            lines.word();
        }
    }
    std::string file(lines.rest());
    if (file.empty()) lines.fail_expected("the name of a texture", "");
    std::replace(file.begin(), file.end(), '\\', '/');
    found.text += std::string(name) + (clamp ? " -clamp on " : " ") + file + "\n";
    found.textures.push_back(std::move(file));
}

/// Three numbers, or one for all of them.
void color_statement(std::string_view name, Lines& lines, MtlText& found) {
    lines.cut_comment();
    std::array<std::string_view, 3> parts;
    for (size_t i = 0; i < 3; ++i) {
        if (i == 1 && lines.rest().empty()) {
            parts[1] = parts[2] = parts[0];
            break;
        }
        parts[i] = lines.rest().substr(0, lines.rest().find_first_of(kSpace));
        if (!(lines.number("a part of a colour, a finite number") >= 0.0)) {
            lines.fail_expected("a part of a colour of at least 0", parts[i]);
        }
    }
    found.text += name;
    for (const std::string_view part : parts) {
        found.text += ' ';
        found.text += part;
    }
    found.text += '\n';
}

/// The number of d or Tr, as it stands.
std::string alpha(Lines& lines) {
    lines.cut_comment();
    if (lines.rest().starts_with("-halo")) lines.word();
    std::string value(lines.rest().substr(0, lines.rest().find_first_of(kSpace)));
    const double number = lines.number("a number from 0 to 1");
    if (!(number >= 0.0 && number <= 1.0)) lines.fail_expected("a number from 0 to 1", value);
    return value;
}

}  // namespace

ObjText check_obj(std::string_view text, const MeshLimits& limits, const std::string& file) {
    return ObjCheck(text, limits, file).run();
}

std::vector<std::string> material_files_of(std::string_view text, const std::string& file) {
    Lines lines(text, file);
    std::vector<std::string> names;
    while (lines.next()) {
        if (lines.word() == "mtllib" && !lines.rest().empty()) names.emplace_back(lines.rest());
    }
    return names;
}

MtlText check_mtl(std::string_view text, const std::string& file) {
    Lines lines(text, file);
    MtlText found;
    std::string material;
    bool has_d = false;
    while (lines.next()) {
        const std::string_view name = lines.word();
        const bool is_color = name == "Kd" || name == "Ke";
        const bool is_alpha = name == "d" || name == "Tr";
        const bool is_map = name == "map_Kd" || name == "map_Ke" || name == "map_d";
        if ((is_color || is_alpha || is_map) && material.empty()) {
            lines.fail_expected("newmtl before it", name);
        }
        if (name == "newmtl") {
            material = lines.rest();
            if (material.empty()) lines.fail_expected("the name of a material", "");
            found.text += "newmtl " + material + "\n";
            has_d = false;
        } else if (is_map) {
            map_statement(name, lines, found);
        } else if (is_color) {
            color_statement(name, lines, found);
            if (name == "Kd") found.with_kd.insert(material);
        } else if (is_alpha) {
            const std::string value = alpha(lines);
            has_d = has_d || name == "d";
            if (name == "d" || !has_d) found.text += std::string(name) + " " + value + "\n";
        }
    }
    return found;
}

}  // namespace probebake
