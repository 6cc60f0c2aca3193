// Meshes for tests: boxes turned any way, landscapes with houses, soups.
#pragma once

#include <cmath>

#include "math/random.h"
#include "mesh/triangle_mesh.h"

namespace probebake::test {

inline uint32_t add_vertex(TriangleMesh& mesh, const Vec3& position) {
    mesh.positions.push_back(position);
    return static_cast<uint32_t>(mesh.positions.size() - 1);
}

/// Corners counter-clockwise; texture coordinates from (0, 0) at `a` to (1, 1) at `c`.
inline void add_quad(TriangleMesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                     uint32_t material = 0) {
    mesh.texture_coordinates.resize(mesh.positions.size(), Vec2(0.0));
    const uint32_t first = add_vertex(mesh, a);
    add_vertex(mesh, b);
    add_vertex(mesh, c);
    add_vertex(mesh, d);
    for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
        mesh.texture_coordinates.push_back(uv);
    }
    mesh.triangles.push_back({{first, first + 1, first + 2}, material});
    mesh.triangles.push_back({{first, first + 2, first + 3}, material});
}

inline uint32_t add_material(TriangleMesh& mesh, const Rgb& color,
                             const Rgb& emission = Rgb(0.0f)) {
    mesh.materials.push_back({.base_color = color, .emission = emission});
    return static_cast<uint32_t>(mesh.materials.size() - 1);
}

inline glm::dmat3 random_rotation(RandomStream& random) {
    const auto angle = [&] { return 6.283185307179586 * random.uniform(); };
    const auto turn = [](int axis, double a) {
        glm::dmat3 m(1.0);
        const int i = (axis + 1) % 3;
        const int j = (axis + 2) % 3;
        m[i][i] = m[j][j] = std::cos(a);
        m[i][j] = std::sin(a);
        m[j][i] = -std::sin(a);
        return m;
    };
    const glm::dmat3 x = turn(0, angle());
    const glm::dmat3 y = turn(1, angle());
    return turn(2, angle()) * y * x;
}

/// Faces outwards.
inline void add_box(TriangleMesh& mesh, const Vec3& middle, const Vec3& half,
                    const glm::dmat3& turned = glm::dmat3(1.0), uint32_t material = 0) {
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            const auto corner = [&](double u, double v) {
                Vec3 p(0.0);
                p[axis] = side * half[axis];
                p[(axis + 1) % 3] = u * half[(axis + 1) % 3];
                p[(axis + 2) % 3] = side * v * half[(axis + 2) % 3];
                return middle + turned * p;
            };
            add_quad(mesh, corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1), material);
        }
    }
}

/// A closed room of 8 m within hollow walls of 2 m, from (0, 0, 0) to (12, 12, 12).
inline TriangleMesh make_room(bool double_sided = false) {
    TriangleMesh mesh;
    mesh.materials.push_back({.double_sided = double_sided});
    add_box(mesh, Vec3(6.0), Vec3(6.0));
    add_box(mesh, Vec3(6.0), Vec3(-4.0));  // mirrored: faces inwards
    return mesh;
}

/// Hills of side × side quads over [0, extent]², and boxes on and in them: 2 side² + 12 boxes
/// triangles.
inline TriangleMesh make_level(int side, int boxes, double extent_m, uint64_t seed) {
    TriangleMesh mesh;
    const uint32_t ground = add_material(mesh, {0.3f, 0.4f, 0.2f});
    const uint32_t wall = add_material(mesh, {0.6f, 0.5f, 0.4f});
    const uint32_t lamp = add_material(mesh, {0.8f, 0.8f, 0.8f}, {20.0f, 15.0f, 10.0f});
    const auto height_m = [&](double x, double z) {
        const double u = 6.283185307179586 * x / extent_m;
        const double v = 6.283185307179586 * z / extent_m;
        return 0.02 * extent_m *
               (3.0 + 2.0 * std::sin(u + 0.3) * std::cos(1.5 * v) + std::sin(5.0 * u - 3.0 * v) +
                0.2 * std::cos(31.0 * u + 17.0 * v));
    };
    for (int j = 0; j <= side; ++j) {
        for (int i = 0; i <= side; ++i) {
            const double x = extent_m * i / side;
            const double z = extent_m * j / side;
            add_vertex(mesh, {x, height_m(x, z), z});
        }
    }
    const auto at = [&](int i, int j) { return static_cast<uint32_t>(j * (side + 1) + i); };
    for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
            mesh.triangles.push_back({{at(i, j), at(i, j + 1), at(i + 1, j + 1)}, ground});
            mesh.triangles.push_back({{at(i, j), at(i + 1, j + 1), at(i + 1, j)}, ground});
        }
    }
    RandomStream random(random_key({0x6C6576656C, seed}));
    for (int b = 0; b < boxes; ++b) {
        const double x = extent_m * (0.1 + 0.8 * random.uniform());
        const double z = extent_m * (0.1 + 0.8 * random.uniform());
        const Vec3 half = extent_m * (Vec3(0.003) + 0.02 * Vec3(random.uniform(), random.uniform(),
                                                                random.uniform()));
        add_box(mesh, {x, height_m(x, z) + 0.5 * half.y, z}, half, random_rotation(random),
                b % 16 == 0 ? lamp : wall);
    }
    mesh.texture_coordinates.resize(mesh.positions.size(), Vec2(0.0));
    return mesh;
}

/// Triangles of all sizes and kinds within [0, extent]³, some of them slivers or on whole metres.
inline TriangleMesh make_soup(int count, double extent_m, uint64_t seed) {
    TriangleMesh mesh;
    RandomStream random(random_key({0x736F7570, seed}));
    for (int m = 0; m < 3; ++m) {
        add_material(mesh, {0.2f * static_cast<float>(m), 0.5f, 0.1f}, Rgb(m == 2 ? 3.0f : 0.0f));
    }
    const auto point = [&] {
        return extent_m * Vec3(random.uniform(), random.uniform(), random.uniform());
    };
    for (int i = 0; i < count; ++i) {
        Vec3 a = point();
        const double size = std::pow(0.5, static_cast<double>(random.below(6)));
        Vec3 b = glm::mix(a, point(), size);
        Vec3 c = random.below(8) == 0 ? glm::mix(a, b, 1.3) : glm::mix(a, point(), size);
        if (random.below(4) == 0) {
            a = glm::floor(a);
            b = glm::floor(b);
            c = glm::floor(c);
        }
        const uint32_t first = add_vertex(mesh, a);
        add_vertex(mesh, glm::min(b, Vec3(extent_m)));
        add_vertex(mesh, glm::min(c, Vec3(extent_m)));
        mesh.triangles.push_back(
            {{first, first + 1, first + 2}, static_cast<uint32_t>(random.below(3))});
    }
    return mesh;
}

}  // namespace probebake::test
