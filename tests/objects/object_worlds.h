// Scenes of objects in the cube [1, 15]³, for rays of the families in the cube [0, 16]³.
#pragma once

#include <string>
#include <vector>

#include "objects/object_bounds.h"
#include "support/ray_families.h"

namespace probebake::test {

inline constexpr double kWorldSide = 16.0;

struct ObjectWorld {
    std::string name;
    ObjectSet set;

    /// Boxes under a root whose centre planes are the integers that the ray families aim at.
    ObjectBoxes boxes() const {
        ObjectBoxes boxes = safe_boxes(set);
        boxes.root = {Vec3(0.0), Vec3(kWorldSide)};
        return boxes;
    }
};

inline Vec3 place(RandomStream& random) { return random_point(random, 10.0) + Vec3(3.0); }

/// A star or a comb: concave, in a plane of any direction.
inline std::vector<Vec3> concave_polygon(RandomStream& random, const Vec3& center, double size) {
    const Vec3 normal = random_direction(random);
    const Vec3 u = glm::normalize(
        glm::cross(normal, std::abs(normal.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)));
    const Vec3 v = glm::cross(normal, u);
    std::vector<Vec3> vertices;
    constexpr int kTips = 5;
    for (int i = 0; i < 2 * kTips; ++i) {
        const double angle = 3.14159265358979 * i / kTips;
        const double r = i % 2 == 0 ? size : 0.4 * size;
        vertices.push_back(center + r * (std::cos(angle) * u + std::sin(angle) * v));
    }
    return vertices;
}

/// A cube's faces on integer planes, as quads or as triangles.
inline void add_cube(ObjectSet& set, const Vec3& low, double edge, bool as_triangles) {
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {0.0, edge}) {
            std::vector<Vec3> face;
            for (const auto& [a, b] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}) {
                Vec3 v = low;
                v[axis] += side;
                v[(axis + 1) % 3] += a * edge;
                v[(axis + 2) % 3] += b * edge;
                face.push_back(v);
            }
            if (as_triangles) {
                set.add(Triangle{face[0], face[1], face[2]});
                set.add(Triangle{face[0], face[2], face[3]});
            } else {
                set.add_polygon(face);
            }
        }
    }
}

inline std::vector<ObjectWorld> object_worlds() {
    std::vector<ObjectWorld> worlds;
    RandomStream random(random_key({0x6F626A65637473}));
    const auto size = [&] { return 0.1 + 0.8 * random.uniform(); };
    const auto add = [&](const char* name, int count, auto add_one) {
        worlds.push_back({name, {}});
        for (int i = 0; i < count; ++i) add_one(worlds.back().set);
    };
    add("spheres", 150, [&](ObjectSet& set) {
        const Vec3 at = place(random);
        set.add(Sphere{at, size()});
    });
    add("cones", 150, [&](ObjectSet& set) {
        const Vec3 base = place(random);
        const Vec3 apex = base + random_direction(random) * (0.3 + random.uniform());
        const double radius = size();
        set.add(
            Cone{base, radius, apex, random.below(2) == 0 ? radius : random.uniform() * radius});
    });
    add("cylinders along axes", 120, [&](ObjectSet& set) {
        const Vec3 base = random_corner(random, 9.0) + Vec3(3.0);
        set.add(Cone{base, 0.5, base + 2.0 * random_axis(random), 0.5});
    });
    add("triangles", 200, [&](ObjectSet& set) {
        const Vec3 at = place(random);
        set.add(Triangle{at, at + random_direction(random), at + random_direction(random)});
    });
    add("concave polygons", 100, [&](ObjectSet& set) {
        const Vec3 at = place(random);
        set.add_polygon(concave_polygon(random, at, 2.0 * size()));
    });
    add("cubes on split planes", 25, [&](ObjectSet& set) {
        const Vec3 low = random_corner(random, 11.0) + Vec3(1.0);
        add_cube(set, low, static_cast<double>(1 + random.below(3)), random.below(2) == 0);
    });
    add("everything", 40, [&](ObjectSet& set) {
        set.add(Sphere{place(random), size()});
        const Vec3 base = place(random);
        set.add(Cone{base, 0.5, base + random_direction(random), 0.1});
        const Vec3 at = place(random);
        set.add(Triangle{at, at + random_direction(random), at + random_direction(random)});
        set.add_polygon(concave_polygon(random, place(random), 1.0));
        add_cube(set, random_corner(random, 11.0) + Vec3(1.0), 2.0, false);
    });
    return worlds;
}

}  // namespace probebake::test
