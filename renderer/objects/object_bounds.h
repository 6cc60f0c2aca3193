// Boxes of objects.
//
// object_box is tight: spheres, vertices, and for cones the boxes of their two end discs, whose
// half-width on an axis is r·sqrt(1 − n²), n being the axis's component there.
#pragma once

#include "objects/object_set.h"

namespace probebake {

Box object_box(const ObjectSet& set, uint32_t object);

/// As GOLEM must have had them: with these boxes centre-plane trees have the counts of Havran
/// 1999's tables (design figures: 109 of 128 exactly, the others within 0.13 %). Polygons and
/// triangles thinner than 0.02 on an axis are widened there by 0.02 on both sides. Cones are
/// scaled: low · 0.999 and high · 1.001, with their signs, which shrinks boxes on the negative
/// side: hits are lost. For that comparison only.
Box object_box_1999(const ObjectSet& set, uint32_t object);

/// Boxes of all objects that hold every hit that rounding can report, and a root around them.
struct ObjectBoxes {
    Box root;
    std::vector<Box> boxes;
};
/// Each box is wider than its object by 1e-9 of the scene's largest coordinate or extent; the root
/// by another 1e-6.
ObjectBoxes safe_boxes(const ObjectSet& set);
/// The root of the tables: wider than all boxes by 0.001.
ObjectBoxes boxes_1999(const ObjectSet& set);

}  // namespace probebake
