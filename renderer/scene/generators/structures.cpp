#include "scene/generators/structures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/generators/houses.h"
#include "scene/generators/palette.h"
#include "scene/generators/random.h"

namespace probebake::worldgen {
namespace {

const Paint kPlank{palette::kTimber, 0.2};
const Paint kPost{palette::kTimberDark, 0.15};

Vec3 on_ground(const Canvas& canvas, const Vec2& at) {
    return {at.x, canvas.ground().height_m(at), at.y};
}

}  // namespace

void draw_line(Canvas& canvas, const Vec3& from_m, const Vec3& to_m, double sag_m,
               const Paint& paint) {
    const Vec3 along = to_m - from_m;
    const double span = std::sqrt(glm::dot(along, along));
    const int pieces = std::max(4, static_cast<int>(span / (2.0 * canvas.voxel_m())));
    Vec3 last = from_m;
    for (int i = 1; i <= pieces; ++i) {
        const double t = static_cast<double>(i) / pieces;
        const Vec3 next = from_m + along * t - kUp * (4.0 * sag_m * t * (1.0 - t));
        canvas.limb(last, next, {0.0, 0.0}, paint);
        last = next;
    }
}

void draw_flags(Canvas& canvas, const Vec2& from_m, const Vec2& to_m, double height_m) {
    constexpr std::array<Rgb, 5> kCloths = {Rgb(0.06f, 0.13f, 0.34f), Rgb(0.62f, 0.60f, 0.55f),
                                            Rgb(0.42f, 0.07f, 0.05f), Rgb(0.07f, 0.22f, 0.09f),
                                            Rgb(0.55f, 0.39f, 0.06f)};
    const Vec3 from = on_ground(canvas, from_m) + kUp * height_m;
    const Vec3 to = on_ground(canvas, to_m) + kUp * height_m;
    for (const Vec3& top : {from, to}) {
        canvas.limb(top - kUp * (height_m + 0.5), top, {0.1, 0.07}, kPost);
    }
    const double sag = 0.06 * glm::length(to_m - from_m);
    draw_line(canvas, from, to, sag, kPost);
    const int flags = static_cast<int>(glm::length(to_m - from_m) / 0.75);
    for (int i = 1; i < flags; ++i) {
        const double t = static_cast<double>(i) / flags;
        const Vec3 at = from + (to - from) * t - kUp * (4.0 * sag * t * (1.0 - t));
        const Paint cloth{kCloths[static_cast<size_t>(i) % kCloths.size()], 0.1, Layer::kBuilding,
                          Rgb(0.0f)};
        canvas.limb(at - kUp * 0.3, at - kUp * 0.6, {0.0, 0.0}, cloth);
    }
}

void draw_bridge(Canvas& canvas, const Vec3& from_m, const Vec3& to_m, double width_m) {
    const Vec3 along = to_m - from_m;
    const Vec2 flat(along.x, along.z);
    const double span = glm::length(flat);
    const Vec3 across = Vec3(-flat.y, 0.0, flat.x) / span;
    const double rise = 0.06 * span;
    const double step = 0.45 * canvas.voxel_m();
    const auto deck = [&](double s, double side) {
        const double t = s / span;
        return from_m + along * t + kUp * (4.0 * rise * t * (1.0 - t)) + across * side;
    };
    for (double s = 0.0; s <= span; s += step) {
        for (double side = -0.5 * width_m; side <= 0.5 * width_m; side += step) {
            canvas.put(canvas.voxel_at(deck(s, side)), kPlank);
        }
    }
    for (const double side : {-0.5 * width_m, 0.5 * width_m}) {
        for (double s = 0.0; s <= span; s += 2.0) {
            canvas.limb(deck(s, side) - kUp * 3.0, deck(s, side) + kUp * 1.1, {0.08, 0.06}, kPost);
        }
        draw_line(canvas, deck(0.0, side) + kUp * 1.1, deck(span, side) + kUp * 1.1, -rise, kPlank);
    }
}

void draw_river_bridge(Canvas& canvas, const River& river, double along, double width_m) {
    const Vec2 middle = river.curve().at(along);
    const Vec2 heading = river.curve().at(along + 0.01) - river.curve().at(along - 0.01);
    const Vec2 across = Vec2(-heading.y, heading.x) / glm::length(heading);
    double reach = 1.0;
    while (river.depth_m(middle + across * reach) > -1.0 ||
           river.depth_m(middle - across * reach) > -1.0) {
        reach += 0.5;
    }
    draw_bridge(canvas, on_ground(canvas, middle - across * reach),
                on_ground(canvas, middle + across * reach), width_m);
}

void draw_aqueduct(Canvas& canvas, const Aqueduct& a) {
    const double width = 2.4;
    const double tier = 2.6 * a.span_m;  // height of one tier of arches
    const IVec3 lo = canvas.voxel_at({a.from_m.x - 0.5 * width, 0.0, a.from_m.y});
    const IVec3 hi =
        canvas.voxel_at({a.from_m.x + 0.5 * width, a.level_m, a.from_m.y + a.length_m});
    for (int z = lo.z; z <= hi.z; ++z) {
        const double s = canvas.center_m({0, 0, z}).z - a.from_m.y;
        const double in_span = s - a.span_m * std::floor(s / a.span_m) - 0.5 * a.span_m;
        for (int x = lo.x; x <= hi.x; ++x) {
            const bool face = x == lo.x || x == hi.x;
            for (int y = std::max(0, canvas.ground().top(x, z) - 2); y <= hi.y; ++y) {
                const double below = a.level_m - canvas.center_m({x, y, z}).y;
                const double in_tier = below - tier * std::floor(below / tier);
                // Under each tier's band of 1.5 m opens a half circle with straight jambs.
                const double radius = 0.5 * a.span_m - 1.1;
                const double drop = in_tier - 1.5 - radius;
                const bool open = in_tier > 1.5 && std::abs(in_span) < radius &&
                                  (drop > 0.0 || in_span * in_span + drop * drop < radius * radius);
                const bool channel = !face && below < 0.7;
                if (open || channel) continue;
                const bool hollow = !face && below > 1.4 && std::abs(in_span) > radius + 0.6;
                if (!hollow) canvas.put({x, y, z}, masonry(canvas, {x, y, z}, a.stone));
            }
        }
    }
}

void draw_town_wall(Canvas& canvas, const std::vector<Vec2>& corners_m, double height_m,
                    double gate_m, const Rgb& stone) {
    const double step = 0.5 * canvas.voxel_m();
    for (size_t i = 0; i < corners_m.size(); ++i) {
        const Vec2 from = corners_m[i];
        const Vec2 along = corners_m[(i + 1) % corners_m.size()] - from;
        const double span = glm::length(along);
        const Vec2 across = Vec2(-along.y, along.x) / span;
        for (double s = 0.0; s <= span; s += step) {
            const bool gate = std::abs(s - 0.5 * span) < 0.5 * gate_m;
            const bool merlon = std::fmod(s, 1.6) < 0.9;
            for (double side = -0.5; side <= 0.5; side += step) {
                const bool face = std::abs(side) > 0.5 - step;
                const Vec3 foot = on_ground(canvas, from + along * (s / span) + across * side);
                const IVec3 base = canvas.voxel_at(foot);
                const int tall = static_cast<int>(std::lround(height_m / canvas.voxel_m()));
                const int crest = static_cast<int>(std::lround(0.8 / canvas.voxel_m()));
                const int under = static_cast<int>(std::lround(3.6 / canvas.voxel_m()));
                for (int y = gate ? under : -2; y < tall + (merlon && face ? crest : 0); ++y) {
                    const bool inside = !face && y > 0 && y < tall - 1;
                    const IVec3 v = base + IVec3(0, y, 0);
                    if (!inside) canvas.put(v, masonry(canvas, v, stone));
                }
            }
        }
    }
}

void draw_fence(Canvas& canvas, const std::vector<Vec2>& through_m) {
    if (!canvas.resolves(0.2)) return;
    for (size_t i = 0; i + 1 < through_m.size(); ++i) {
        const Vec2 along = through_m[i + 1] - through_m[i];
        const int posts = std::max(1, static_cast<int>(glm::length(along) / 2.0));
        for (int k = 0; k < posts; ++k) {
            const Vec3 here = on_ground(canvas, through_m[i] + along * (1.0 * k / posts));
            const Vec3 next = on_ground(canvas, through_m[i] + along * ((k + 1.0) / posts));
            canvas.limb(here - kUp * 0.3, here + kUp * 1.3, {0.08, 0.07}, kPost);
            for (const double y : {0.6, 1.1}) {
                canvas.limb(here + kUp * y, next + kUp * y, {0.03, 0.03}, kPlank);
            }
        }
    }
}

void draw_lamp(Canvas& canvas, const Vec2& at_m, double height_m) {
    const Vec3 foot = on_ground(canvas, at_m);
    canvas.limb(foot - kUp * 0.3, foot + kUp * height_m, {0.06, 0.05}, kPost);
    draw_lantern(canvas, foot + kUp * (height_m + canvas.voxel_m()));
}

void draw_temple_ruin(Canvas& canvas, const Vec2& corner_m, RandomStream random) {
    const Vec2 extent(14.0, 26.0);
    const Paint stone{palette::kSandstonePale, 0.14};
    double level = 0.0;
    for (const Vec2 share : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)}) {
        level = std::max(level, canvas.ground().height_m(corner_m + share * extent));
    }
    for (int step = 0; step < 3; ++step) {
        const double in = 0.6 * step;
        canvas.box(
            {corner_m.x + in, level - 4.0 * (step == 0 ? 1.0 : 0.0) + 0.4 * step, corner_m.y + in},
            {corner_m.x + extent.x - in, level + 0.4 * (step + 1), corner_m.y + extent.y - in},
            stone);
    }
    const double base = level + 1.2;
    for (int row = 0; row < 2; ++row) {
        double last_top = 0.0;
        for (int i = 0; i < 7; ++i) {
            const Vec3 foot(corner_m.x + 2.2 + row * (extent.x - 4.4), base,
                            corner_m.y + 2.4 + i * 3.5);
            const double tall = random.uniform() < 0.55 ? 8.0 : between(random, 0.8, 6.5);
            canvas.limb(foot, foot + kUp * tall, {0.62, 0.52}, stone);
            // An architrave survives where two neighbouring columns stand.
            if (tall == 8.0 && last_top == 8.0) {
                canvas.box(foot + Vec3(-0.6, 8.0, -3.9), foot + Vec3(0.6, 8.9, 0.5), stone);
            }
            last_top = tall;
            if (tall < 8.0) {
                const Vec3 drum = foot + random_offset(random, 1.5, 4.0);
                canvas.limb(drum, drum + random_azimuth(random) * 1.6, {0.5, 0.5}, stone);
            }
        }
    }
}

void draw_lookout(Canvas& canvas, const Vec2& at_m, double height_m, double snow) {
    const double half = 1.8;
    const Vec3 foot = on_ground(canvas, at_m);
    const double deck = foot.y + height_m;
    for (const double sx : {-1.0, 1.0}) {
        for (const double sz : {-1.0, 1.0}) {
            const Vec3 leg(foot.x + sx * (half + 0.7), foot.y - 2.0, foot.z + sz * (half + 0.7));
            const Vec3 top(foot.x + sx * half, deck + 2.6, foot.z + sz * half);
            canvas.limb(leg, top, {0.14, 0.12}, kPost);
            for (double y = 0.0; y + 3.0 < height_m; y += 3.0) {
                const double w = half + 0.7 * (1.0 - y / height_m);
                canvas.limb({foot.x - sx * w, foot.y + y, foot.z + sz * w},
                            {foot.x + sx * w, foot.y + y + 3.0, foot.z + sz * w}, {0.05, 0.05},
                            kPlank);
            }
        }
    }
    canvas.box({foot.x - half - 0.4, deck, foot.z - half - 0.4},
               {foot.x + half + 0.4, deck + canvas.voxel_m(), foot.z + half + 0.4}, kPlank);
    for (const double y : {0.6, 1.1}) {
        for (const double side : {-half, half}) {
            canvas.limb({foot.x - half, deck + y, foot.z + side},
                        {foot.x + half, deck + y, foot.z + side}, {0.03, 0.03}, kPlank);
            canvas.limb({foot.x + side, deck + y, foot.z - half},
                        {foot.x + side, deck + y, foot.z + half}, {0.03, 0.03}, kPlank);
        }
    }
    const Paint roof{snow > 0.0 ? palette::kSnow : palette::kTimberDark, 0.1, Layer::kBuilding,
                     Rgb(0.0f)};
    for (double in = 0.0; in < half + 0.7; in += canvas.voxel_m()) {
        const double w = half + 0.7 - in;
        canvas.box({foot.x - w, deck + 2.6 + 0.7 * in, foot.z - w},
                   {foot.x + w, deck + 2.6 + 0.7 * in + canvas.voxel_m(), foot.z + w}, roof);
    }
}

}  // namespace probebake::worldgen
