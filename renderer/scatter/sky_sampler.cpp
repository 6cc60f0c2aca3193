#include "scatter/sky_sampler.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace probebake {
namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

SkySampler::SkySampler(const Sky& sky) {
    const int texels = sky.texels();
    if (texels == 0 || sky.black()) return;
    columns_ = std::min(texels, kMostColumns);
    rows_ = std::max(1, columns_ / 2);
    // Places in a cell so close that no texel lies between them, whatever the picture's rotation.
    const int per_cell = 2 * ((texels + columns_ - 1) / columns_) + 1;
    weights_.resize(static_cast<size_t>(rows_) * static_cast<size_t>(columns_));
    cumulative_.resize(weights_.size());
    row_sums_.resize(static_cast<size_t>(rows_));
    size_t at = 0;
    for (int row = 0; row < rows_; ++row) {
        double sum = 0.0;
        for (int column = 0; column < columns_; ++column, ++at) {
            double mean = 0.0;
            for (int j = 0; j < per_cell; ++j) {
                for (int i = 0; i < per_cell; ++i) {
                    const double inset = 1e-6;
                    const auto place = [&](int k) {
                        return inset + (1.0 - 2.0 * inset) * k / (per_cell - 1);
                    };
                    const Rgb radiance = sky.radiance(equirect_direction(
                        {(column + place(i)) / columns_, (row + place(j)) / rows_}));
                    mean += double{radiance.r + radiance.g + radiance.b};
                }
            }
            mean /= 3.0 * per_cell * per_cell;
            weights_[at] = static_cast<float>(mean * row_solid_angle(row));
            sum += double{weights_[at]};
            cumulative_[at] = static_cast<float>(sum);
        }
        total_ += sum;
        row_sums_[static_cast<size_t>(row)] = total_;
    }
}

double SkySampler::row_solid_angle(int row) const {
    const double top = std::sin(kPi * (0.5 - static_cast<double>(row) / rows_));
    const double bottom = std::sin(kPi * (0.5 - (row + 1.0) / rows_));
    return 2.0 * kPi / columns_ * (top - bottom);
}

double SkySampler::cell_weight(int row, int column) const {
    return double{weights_[static_cast<size_t>(row) * static_cast<size_t>(columns_) +
                           static_cast<size_t>(column)]};
}

double SkySampler::cell_pdf(int row, int column) const {
    return cell_weight(row, column) / (total_ * row_solid_angle(row));
}

SkySampler::Sample SkySampler::sample(double u, double v) const {
    const auto r = std::upper_bound(row_sums_.begin(), row_sums_.end(), u * total_);
    const int row = std::min(static_cast<int>(r - row_sums_.begin()), rows_ - 1);
    const auto begin = cumulative_.begin() + static_cast<ptrdiff_t>(row) * columns_;
    const double before = row > 0 ? row_sums_[static_cast<size_t>(row) - 1] : 0.0;
    const double row_sum = row_sums_[static_cast<size_t>(row)] - before;
    // What is left of u within the row chooses the height in the cell, v the cell and the rest.
    const double height = std::clamp((u * total_ - before) / row_sum, 0.0, 1.0 - 0x1.0p-53);
    const double target = v * row_sum;
    const auto c = std::upper_bound(begin, begin + columns_, static_cast<float>(target));
    int column = std::min(static_cast<int>(c - begin), columns_ - 1);
    while (column > 0 && !(cell_weight(row, column) > 0.0)) --column;
    const double left = column > 0 ? double{begin[column - 1]} : 0.0;
    const double across = std::clamp((target - left) / cell_weight(row, column), 0.0, 1.0);
    const double top = std::sin(kPi * (0.5 - static_cast<double>(row) / rows_));
    const double bottom = std::sin(kPi * (0.5 - (row + 1.0) / rows_));
    const double y = top + (bottom - top) * height;
    const double ring = std::sqrt(std::max(0.0, 1.0 - y * y));
    const double longitude = (0.5 - (column + across) / columns_) * 2.0 * kPi;
    return {{std::sin(longitude) * ring, y, std::cos(longitude) * ring}, cell_pdf(row, column)};
}

double SkySampler::pdf(const Vec3& direction) const {
    const Vec2 at = equirect_position(direction);
    const int column = std::clamp(static_cast<int>(at.x * columns_), 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(at.y * rows_), 0, rows_ - 1);
    return cell_pdf(row, column);
}

}  // namespace probebake
