#include "mesh/texture_pyramid.h"

#include <algorithm>
#include <cmath>

#include "math/srgb.h"

namespace probebake {
namespace {

/// Taps along the longer axis of a footprint at most; beyond it is blurred across.
constexpr double kMostTaps = 16.0;

int wrapped(int i, int size, TextureWrap wrap) {
    const auto modulo = [](int a, int n) { return ((a % n) + n) % n; };
    switch (wrap) {
        case TextureWrap::kRepeat:
            return modulo(i, size);
        case TextureWrap::kClamp:
            return std::clamp(i, 0, size - 1);
        case TextureWrap::kMirror: {
            const int at = modulo(i, 2 * size);
            return at < size ? at : 2 * size - 1 - at;
        }
    }
    return 0;
}

/// Where a coordinate falls in a row of `size` texels; far ones are brought near first.
double in_texels(double u, int size, TextureWrap wrap) {
    if (wrap == TextureWrap::kClamp) return std::clamp(u, -1.0, 2.0) * size;
    return (u - 2.0 * std::floor(0.5 * u)) * size;
}

/// The part of a row that texel i of a row of `to` covers in one of `from` texels.
struct Covered {
    int first;
    int last;  // included
    double begin;
    double end;

    Covered(int i, int from, int to)
        : begin(static_cast<double>(i) * from / to), end(static_cast<double>(i + 1) * from / to) {
        first = static_cast<int>(begin);
        last = std::min(from, static_cast<int>(std::ceil(end))) - 1;
    }
    float weight(int texel) const {
        const double length = std::min(end, texel + 1.0) - std::max(begin, double(texel));
        return static_cast<float>(length / (end - begin));
    }
};

}  // namespace

TexturePyramid::TexturePyramid(const Texture& texture, bool cut_out)
    : texture_(texture), cut_out_(cut_out), sizes_{{texture.width_px, texture.height_px}} {
    while (sizes_.back().width > 1 || sizes_.back().height > 1) add_level();
}

void TexturePyramid::add_level() {
    const int from = levels() - 1;
    const Size above = sizes_.back();
    const Size size{std::max(1, above.width / 2), std::max(1, above.height / 2)};
    std::vector<Texel> texels;
    std::vector<uint8_t> alphas;
    texels.reserve(static_cast<size_t>(size.width) * static_cast<size_t>(size.height));
    for (int y = 0; y < size.height; ++y) {
        const Covered rows(y, above.height, size.height);
        for (int x = 0; x < size.width; ++x) {
            const Covered columns(x, above.width, size.width);
            Rgba sum(0.0f);
            uint8_t largest = 0;
            for (int j = rows.first; j <= rows.last; ++j) {
                for (int i = columns.first; i <= columns.last; ++i) {
                    sum += rows.weight(j) * columns.weight(i) * texel(from, i, j);
                    if (cut_out_) largest = std::max(largest, alpha(from, i, j));
                }
            }
            Texel mean{};
            for (int c = 0; c < 4; ++c) {
                mean[static_cast<size_t>(c)] =
                    static_cast<uint16_t>(std::min(65535.0f, std::floor(sum[c] * 65535.0f + 0.5f)));
            }
            texels.push_back(mean);
            if (cut_out_) alphas.push_back(largest);
        }
    }
    sizes_.push_back(size);
    texels_.push_back(std::move(texels));
    largest_alpha_.push_back(std::move(alphas));
}

Rgba TexturePyramid::texel(int level, int x, int y) const {
    const Size& size = sizes_[static_cast<size_t>(level)];
    const size_t at =
        static_cast<size_t>(y) * static_cast<size_t>(size.width) + static_cast<size_t>(x);
    if (level > 0) {
        const Texel& t = texels_[static_cast<size_t>(level - 1)][at];
        return Rgba(t[0], t[1], t[2], t[3]) / 65535.0f;
    }
    const std::array<uint8_t, 4>& t = texture_.texels[at];
    const Rgb color(srgb_to_linear(t[0]), srgb_to_linear(t[1]), srgb_to_linear(t[2]));
    if (!cut_out_) return {color, 1.0f};
    const float alpha = static_cast<float>(t[3]) / 255.0f;
    return {color * alpha, alpha};
}

uint8_t TexturePyramid::alpha(int level, int x, int y) const {
    const Size& size = sizes_[static_cast<size_t>(level)];
    const size_t at =
        static_cast<size_t>(y) * static_cast<size_t>(size.width) + static_cast<size_t>(x);
    return level == 0 ? texture_.texels[at][3] : largest_alpha_[static_cast<size_t>(level - 1)][at];
}

Rgba TexturePyramid::bilinear(int level, const Vec2& uv) const {
    const Size& size = sizes_[static_cast<size_t>(level)];
    const double x = in_texels(uv.x, size.width, texture_.wrap_u) - 0.5;
    const double y = in_texels(uv.y, size.height, texture_.wrap_v) - 0.5;
    const double left = std::floor(x);
    const double top = std::floor(y);
    const auto fx = static_cast<float>(x - left);
    const auto fy = static_cast<float>(y - top);
    const auto at = [&](int dx, int dy) {
        return texel(level, wrapped(static_cast<int>(left) + dx, size.width, texture_.wrap_u),
                     wrapped(static_cast<int>(top) + dy, size.height, texture_.wrap_v));
    };
    return (1.0f - fy) * ((1.0f - fx) * at(0, 0) + fx * at(1, 0)) +
           fy * ((1.0f - fx) * at(0, 1) + fx * at(1, 1));
}

Rgba TexturePyramid::mean(const Vec2& uv, const glm::dmat2& spread) const {
    // Eigenvalues of J Jᵀ: squares of the half axes.
    const double middle = 0.5 * (spread[0][0] + spread[1][1]);
    const double apart = std::hypot(0.5 * (spread[0][0] - spread[1][1]), spread[0][1]);
    const double longer = 2.0 * std::sqrt(std::max(0.0, middle + apart));
    const double shorter = 2.0 * std::sqrt(std::max(0.0, middle - apart));
    const double taps = std::clamp(std::ceil(longer / std::max(1.0, shorter)), 1.0, kMostTaps);
    const double width = std::max(1.0, std::max(shorter, longer / taps));
    const double most = levels() - 1.0;
    const double level = std::min(most, std::log2(width));
    const int fine = static_cast<int>(level);
    const int coarse = std::min(fine + 1, levels() - 1);
    const auto between = static_cast<float>(level - fine);

    Vec2 axis(spread[0][1], middle + apart - spread[0][0]);
    if (glm::length(axis) <= 1e-9 * (middle + apart)) {
        axis = spread[0][0] >= spread[1][1] ? Vec2(1.0, 0.0) : Vec2(0.0, 1.0);
    }
    axis *= longer / glm::length(axis);
    const Vec2 step(axis.x / sizes_[0].width, axis.y / sizes_[0].height);
    Rgba sum(0.0f);
    for (double tap = 0.0; tap < taps; tap += 1.0) {
        const Vec2 at = uv + ((tap + 0.5) / taps - 0.5) * step;
        Rgba value = bilinear(fine, at);
        if (between > 0.0f) value += between * (bilinear(coarse, at) - value);
        sum += value;
    }
    return sum / static_cast<float>(taps);
}

float TexturePyramid::largest_alpha(const Vec2& uv, int level) const {
    if (!cut_out_) return 1.0f;
    const Size& size = sizes_[static_cast<size_t>(level)];
    const double x = std::floor(in_texels(uv.x, size.width, texture_.wrap_u));
    const double y = std::floor(in_texels(uv.y, size.height, texture_.wrap_v));
    return static_cast<float>(alpha(level,
                                    wrapped(static_cast<int>(x), size.width, texture_.wrap_u),
                                    wrapped(static_cast<int>(y), size.height, texture_.wrap_v))) /
           255.0f;
}

uint64_t TexturePyramid::memory_bytes() const {
    uint64_t bytes = 0;
    for (size_t i = 0; i < texels_.size(); ++i) {
        bytes += texels_[i].size() * sizeof(Texel) + largest_alpha_[i].size();
    }
    return bytes;
}

}  // namespace probebake
