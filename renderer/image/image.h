// A rectangle of linear RGB, row by row from the top.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "math/vec.h"

namespace probebake {

class Image {
  public:
    Image() = default;
    Image(int width_px, int height_px)
        : width_(width_px),
          height_(height_px),
          pixels_(static_cast<size_t>(width_px) * static_cast<size_t>(height_px), Rgb(0.0f)) {}

    int width() const { return width_; }
    int height() const { return height_; }
    bool empty() const { return pixels_.empty(); }

    Rgb& at(int x, int y) { return pixels_[index(x, y)]; }
    const Rgb& at(int x, int y) const { return pixels_[index(x, y)]; }

    std::span<Rgb> pixels() { return pixels_; }
    std::span<const Rgb> pixels() const { return pixels_; }

    bool operator==(const Image&) const = default;

  private:
    size_t index(int x, int y) const {
        return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
    }

    int width_ = 0;
    int height_ = 0;
    std::vector<Rgb> pixels_;
};

}  // namespace probebake
