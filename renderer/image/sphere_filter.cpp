#include "image/sphere_filter.h"

#include <tbb/parallel_for.h>

namespace probebake {

SphereFilter::SphereFilter(const Cubemap& cubemap) : cubemap_(cubemap) {
    const int n = cubemap.face_size();
    cell_solid_angles_.reserve(static_cast<size_t>(n) * static_cast<size_t>(n));
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            cell_solid_angles_.push_back(static_cast<float>(pixel_solid_angle(x, y, n)));
        }
    }
    for (size_t level = 1; size(level - 1) > 1; ++level) {
        const int side = (size(level - 1) + 1) / 2;
        Level next{side,
                   std::vector<Node>(6 * static_cast<size_t>(side) * static_cast<size_t>(side))};
        tbb::parallel_for(size_t{0}, next.nodes.size(),
                          [&](size_t i) { next.nodes[i] = joined(level, pixel_at(i, side)); });
        levels_.push_back(std::move(next));
    }
}

SphereFilter::Node SphereFilter::cell(const CubePixel& at) const {
    const int n = cubemap_.face_size();
    const auto index =
        static_cast<size_t>(at.y) * static_cast<size_t>(n) + static_cast<size_t>(at.x);
    const glm::vec3 centre(glm::normalize(
        face_direction(at.face, grid_coordinate(at.x, n), grid_coordinate(at.y, n))));
    const float solid_angle = cell_solid_angles_[index];
    return {cubemap_.at(at) * solid_angle, solid_angle, centre, {centre, centre, centre}};
}

SphereFilter::Node SphereFilter::joined(size_t level, const CubePixel& at) const {
    Vec3 light(0.0);
    double solid_angle = 0.0;
    Vec3 centre(0.0);
    std::array<Vec3, 3> light_centres{};
    for_each_child(level, at, [&](const CubePixel& child_at) {
        const Node child = node(level - 1, child_at);
        light += Vec3(child.light);
        solid_angle += static_cast<double>(child.solid_angle);
        centre += Vec3(child.centre) * static_cast<double>(child.solid_angle);
        for (int c = 0; c < 3; ++c) {
            const auto channel = static_cast<size_t>(c);
            light_centres[channel] +=
                Vec3(child.light_centres[channel]) * static_cast<double>(child.light[c]);
        }
    });
    Node node{Rgb(light), static_cast<float>(solid_angle), glm::vec3(glm::normalize(centre)), {}};
    for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<size_t>(c);
        // Of a dark channel any centre does.
        node.light_centres[channel] =
            light[c] > 0.0 ? glm::vec3(glm::normalize(light_centres[channel])) : node.centre;
    }
    return node;
}

uint64_t SphereFilter::memory_bytes(int face_size_px) {
    uint64_t nodes = 0;
    for (auto side = static_cast<uint64_t>(face_size_px); side > 1;) {
        side = (side + 1) / 2;
        nodes += 6 * side * side;
    }
    const auto n = static_cast<uint64_t>(face_size_px);
    return nodes * sizeof(Node) + n * n * sizeof(float);
}

}  // namespace probebake
