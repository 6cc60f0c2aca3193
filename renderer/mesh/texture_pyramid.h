// TexturePyramid: a texture as it looks from any distance.
//
// Level 0 is the picture itself, decoded on the way; level k + 1 is half as wide and high (rounded
// down, 1 at least), each texel the mean over exactly the part of level k that it covers, in linear
// light: 16 bits per channel, 8 bytes a texel. Of cut-out pictures colours are premultiplied by
// alpha, and the largest alpha within every texel is kept, too.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mesh/triangle_mesh.h"

namespace probebake {

using Rgba = glm::vec4;

class TexturePyramid {
  public:
    /// Keeps a reference to the texture. What is no cut-out has alpha 1 everywhere.
    TexturePyramid(const Texture& texture, bool cut_out);

    /// The mean over what is seen around a point: an ellipse of texels (level 0) whose half axes
    /// belong to the symmetric matrix `spread` = J Jᵀ, J being what moves in texels when the point
    /// moves by half of the footprint. Alpha is how much is there; of cut-outs, colours times
    /// alpha.
    Rgba mean(const Vec2& uv, const glm::dmat2& spread) const;

    /// The largest alpha in the texel of that level which the point lies in.
    float largest_alpha(const Vec2& uv, int level) const;
    int levels() const { return static_cast<int>(sizes_.size()); }
    /// Of level 0, in texels.
    Vec2 size() const { return {sizes_[0].width, sizes_[0].height}; }

    uint64_t memory_bytes() const;

  private:
    using Texel = std::array<uint16_t, 4>;
    struct Size {
        int width = 0;
        int height = 0;
    };

    Rgba texel(int level, int x, int y) const;
    uint8_t alpha(int level, int x, int y) const;
    Rgba bilinear(int level, const Vec2& uv) const;
    void add_level();

    const Texture& texture_;
    bool cut_out_;
    std::vector<Size> sizes_;
    std::vector<std::vector<Texel>> texels_;           // from level 1 on
    std::vector<std::vector<uint8_t>> largest_alpha_;  // the same, of cut-outs
};

}  // namespace probebake
