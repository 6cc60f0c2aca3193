// The error table by a second road, for the tests of the first: the outlines of the children drawn
// in an image plane, their union swept from left to right.
//
// Between neighbouring breakpoints (ends and crossings of all outline segments) the union's height
// is linear in x, so that width × height at the middle is exact; rounding leaves about 1e-14.
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "error/child_mask.h"

namespace probebake::test {

inline MaskErrors swept_errors(const Vec3& d) {
    // Any plane across d does; a turned one keeps most outlines off the vertical.
    const Vec3 helper = glm::normalize(glm::cross(d, Vec3(0.3, -0.5, 0.8)));
    const Vec3 right = helper;
    const Vec3 up = glm::cross(d, right);

    using Segment = std::pair<Vec2, Vec2>;
    std::array<std::vector<Segment>, 8> outlines;  // the 12 edges of each child, seen along d
    std::vector<double> breaks;
    for (int child = 0; child < 8; ++child) {
        const auto corner = [&](int k) {
            const Vec3 p(0.5 * ((child & 1) + (k & 1)), 0.25 * ((child & 2) + (k & 2)),
                         0.125 * ((child & 4) + (k & 4)));
            return Vec2(glm::dot(p, right), glm::dot(p, up));
        };
        for (int k = 0; k < 8; ++k) {
            breaks.push_back(corner(k).x);
            for (const int bit : {1, 2, 4}) {
                if ((k & bit) != 0) continue;
                Vec2 a = corner(k);
                Vec2 b = corner(k | bit);
                if (b.x < a.x) std::swap(a, b);
                outlines[static_cast<size_t>(child)].emplace_back(a, b);
            }
        }
    }
    std::vector<Segment> segments;
    for (const auto& outline : outlines) {
        segments.insert(segments.end(), outline.begin(), outline.end());
    }
    for (size_t i = 0; i < segments.size(); ++i) {
        for (size_t j = 0; j < i; ++j) {
            const auto& [a, b] = segments[i];
            const auto& [p, q] = segments[j];
            const Vec2 ab = b - a;
            const Vec2 pq = q - p;
            const double det = ab.x * pq.y - ab.y * pq.x;
            const double t = ((p.x - a.x) * pq.y - (p.y - a.y) * pq.x) / det;
            if (t > 0.0 && t < 1.0) breaks.push_back(a.x + t * ab.x);  // parallel: NaN or far
        }
    }
    std::sort(breaks.begin(), breaks.end());

    MaskErrors areas{};
    for (size_t i = 1; i < breaks.size(); ++i) {
        const double width = breaks[i] - breaks[i - 1];
        const double x = 0.5 * (breaks[i] + breaks[i - 1]);
        if (!(breaks[i - 1] < x && x < breaks[i])) continue;
        struct Span {
            double low, high;
            unsigned bit;
        };
        std::vector<Span> spans;
        for (size_t child = 0; child < 8; ++child) {
            Span span{1e9, -1e9, 1u << child};
            for (const auto& [a, b] : outlines[child]) {
                if (!(a.x <= x && x <= b.x && a.x < b.x)) continue;
                const double y = a.y + (x - a.x) / (b.x - a.x) * (b.y - a.y);
                span.low = std::min(span.low, y);
                span.high = std::max(span.high, y);
            }
            if (span.low < span.high) spans.push_back(span);
        }
        std::sort(spans.begin(), spans.end(),
                  [](const Span& a, const Span& b) { return a.low < b.low; });
        for (size_t mask = 0; mask < kMaskCount; ++mask) {
            double height = 0.0;
            double top = -1e9;
            for (const Span& span : spans) {
                if ((mask & span.bit) == 0) continue;
                height += std::max(0.0, span.high - std::max(span.low, top));
                top = std::max(top, span.high);
            }
            areas[mask] += width * height;
        }
    }
    MaskErrors errors{};
    for (size_t mask = 0; mask < kMaskCount; ++mask) {
        errors[mask] = 1.0 - areas[mask] / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
    }
    return errors;
}

}  // namespace probebake::test
