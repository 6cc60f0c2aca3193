// Means of a cubemap over the sphere with smooth weights around a direction: reflections,
// irradiance.
//
// mean(n) = Σ Ω w L / Σ Ω w over the cells of the grid, Ω a cell's solid angle clipped at the edge
// of its face, w the kernel at the cell's centre: a constant stays that constant, whatever is cut
// off. Cells are taken together in quadtrees, one per face, as far as the kernel is flat across
// them: a node stands for its cells where its solid angle is below (scale / 4)² (Barnes and Hut
// 1986). It is weighed at the centre of its light, which each channel has its own of: there the
// first-order error vanishes, and a lamp of one pixel counts with its own direction however large
// the node. Nodes hold nothing that depends on a kernel. The same sums for any number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "image/cubemap.h"

namespace probebake {

/// Kernels are functions of h = sin²(θ/2) = (1 − cos θ) / 2, θ the angle to the middle, which float
/// resolves where a cosine is 1; scale2 is the square of the angle over which weights change.

/// What a mirror of GGX roughness α shows, seen along its normal (N = V = R, Karis 2013): half
/// vectors as D(h) (n·h), each weighed by n·l. Per solid angle of l that is
/// D(θ/2) cos θ / 4 ∝ cos θ / (α² + (1 − α²) sin²(θ/2))². α = 1 is the cosine alone.
struct GgxKernel {
    float alpha2 = 1.0f;

    float weight(float h) const {
        const float d = alpha2 + (1.0f - alpha2) * h;
        // α⁴ keeps the largest weight at 1.
        return std::max(0.0f, 1.0f - 2.0f * h) * (alpha2 * alpha2) / (d * d);
    }
    float scale2(float h) const { return std::min(1.0f, 4.0f * (h + alpha2)); }
};

/// max(0, cos θ)^exponent.
struct CosineKernel {
    int exponent = 1;

    float weight(float h) const {
        float weight = 1.0f;
        float power = std::max(0.0f, 1.0f - 2.0f * h);
        for (int e = exponent; e > 0; e >>= 1, power *= power) {
            if ((e & 1) != 0) weight *= power;
        }
        return weight;
    }
    float scale2(float) const { return std::min(0.25f, 1.0f / static_cast<float>(exponent)); }
};

/// h of two unit vectors.
inline float haversine(const glm::vec3& a, const glm::vec3& b) {
    const glm::vec3 chord = a - b;
    return 0.25f * glm::dot(chord, chord);
}

class SphereFilter {
  public:
    /// The cubemap must outlive it.
    explicit SphereFilter(const Cubemap& cubemap);

    /// Of the unit direction `normal`; black where every weight is 0.
    template <class Kernel>
    Vec3 mean(const Kernel& kernel, const Vec3& normal) const {
        Sum sum;
        const glm::vec3 n(normal);
        for (const CubeFace face : kCubeFaces) {
            add(kernel, n, levels_.size(), {face, 0, 0}, sum);
        }
        return sum.weight > 0.0 ? sum.light / sum.weight : Vec3(0.0);
    }

    /// Of the nodes, for a cubemap of n pixels per face.
    static uint64_t memory_bytes(int face_size_px);

  private:
    /// What some cells hold together.
    struct Node {
        Rgb light{0.0f};                           // Σ Ω L
        float solid_angle = 0.0f;                  // sr
        glm::vec3 centre{0.0f};                    // unit, of the cells
        std::array<glm::vec3, 3> light_centres{};  // unit, of the light of R, G and B
    };
    struct Level {
        int size = 0;  // nodes per side of a face
        std::vector<Node> nodes;
    };
    struct Sum {
        Vec3 light{0.0};
        double weight = 0.0;
    };

    /// Level 0 are the cells themselves, which are not stored.
    Node node(size_t level, const CubePixel& at) const {
        return level == 0 ? cell(at) : levels_[level - 1].nodes[cube_index(at, size(level))];
    }
    int size(size_t level) const {
        return level == 0 ? cubemap_.face_size() : levels_[level - 1].size;
    }
    Node cell(const CubePixel& at) const;
    Node joined(size_t level, const CubePixel& at) const;

    template <class Kernel>
    void add(const Kernel& kernel, const glm::vec3& normal, size_t level, const CubePixel& at,
             Sum& sum) const;
    /// As a whole.
    template <class Kernel>
    static void add(const Kernel& kernel, const glm::vec3& normal, const Node& node, Sum& sum);
    template <class Visit>
    void for_each_child(size_t level, const CubePixel& at, const Visit& visit) const {
        const int end_x = std::min(2 * at.x + 2, size(level - 1));
        const int end_y = std::min(2 * at.y + 2, size(level - 1));
        for (int y = 2 * at.y; y < end_y; ++y) {
            for (int x = 2 * at.x; x < end_x; ++x) visit(CubePixel{at.face, x, y});
        }
    }

    const Cubemap& cubemap_;
    std::vector<float> cell_solid_angles_;  // of one face
    std::vector<Level> levels_;             // from nodes of 2 × 2 cells to one node per face
};

template <class Kernel>
void SphereFilter::add(const Kernel& kernel, const glm::vec3& normal, size_t level,
                       const CubePixel& at, Sum& sum) const {
    if (level == 0) return add(kernel, normal, cell(at), sum);
    const Node& node = levels_[level - 1].nodes[cube_index(at, size(level))];
    const float h = haversine(normal, node.centre);
    // No corner of a node is farther from its centre than the root of its solid angle.
    const float cosine = 1.0f - 2.0f * h;
    if (cosine < 0.0f && cosine * cosine > node.solid_angle) return;
    if (16.0f * node.solid_angle <= kernel.scale2(h)) return add(kernel, normal, node, sum);
    for_each_child(level, at,
                   [&](const CubePixel& child) { add(kernel, normal, level - 1, child, sum); });
}

template <class Kernel>
void SphereFilter::add(const Kernel& kernel, const glm::vec3& normal, const Node& node, Sum& sum) {
    const float weight = kernel.weight(haversine(normal, node.centre));
    sum.weight += static_cast<double>(weight) * static_cast<double>(node.solid_angle);
    for (int c = 0; c < 3; ++c) {
        const glm::vec3& centre = node.light_centres[static_cast<size_t>(c)];
        const float of_light = kernel.weight(haversine(normal, centre));
        sum.light[c] += static_cast<double>(of_light) * static_cast<double>(node.light[c]);
    }
}

}  // namespace probebake
