#include "bake/probe_places.h"

#include <tbb/parallel_for.h>

#include <chrono>
#include <cmath>

#include "scene/probe_validity.h"

namespace probebake {
namespace {

/// Named in the report; rows name all.
constexpr size_t kMostNamed = 100;

Vec3 most_offset_m(const JobSpec& job, size_t probe) {
    if (!job.validity || !job.validity->relocate) return Vec3(0.0);
    const ProbeGrid* const grid = grid_of(job, probe);
    return grid != nullptr ? kMostCellShare * glm::abs(grid->spacing_m)
                           : Vec3(job.validity->max_offset_m);
}

}  // namespace

PlacesRecord place_probes(const Scene& scene, JobSpec& job, const CancelToken& cancel) {
    const auto start = std::chrono::steady_clock::now();
    const PlaceRules rules = job.validity ? job.validity->rules : PlaceRules{};
    const PlaceFinder finder(scene, rules, job.validity.has_value());
    tbb::parallel_for(size_t{0}, job.probes.size(), [&](size_t p) {
        cancel.throw_if_cancelled();
        ProbeSpec& probe = job.probes[p];
        const Vec3 requested_m = probe.position_m;
        const Vec3 offset_m = most_offset_m(job, p);
        if (offset_m != Vec3(0.0)) probe.position_m = finder.relocated(requested_m, offset_m);
        probe.place = finder.look_at(probe.position_m);
        probe.place->requested_m = requested_m;
        probe.place->moved = probe.position_m != requested_m;
    });
    PlacesRecord record{.octree_bytes = finder.octree_bytes()};
    if (record.octree_bytes > 0) record.triangles = scene.surface.triangles.size();
    record.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return record;
}

Json write_places(const JobSpec& job, const PlacesRecord& record) {
    Json invalid = Json::array();
    uint64_t invalid_count = 0;
    uint64_t moved_count = 0;
    for (const ProbeSpec& probe : job.probes) {
        if (!probe.place) continue;
        if (probe.place->moved) ++moved_count;
        if (probe.place->valid) continue;
        if (++invalid_count <= kMostNamed) invalid.push_back(probe.id);
    }
    Json json = {{"probes", job.probes.size()}, {"invalid", invalid_count},
                 {"moved", moved_count},        {"invalid_probes", std::move(invalid)},
                 {"object_octree", nullptr},    {"seconds", record.seconds}};
    if (record.octree_bytes > 0) {
        json["object_octree"] = {{"triangles", record.triangles}, {"bytes", record.octree_bytes}};
    }
    return json;
}

Json write_place(const ProbePlace& place) {
    Json json = {{"valid", place.valid},
                 {"inside_geometry", place.inside_geometry},
                 {"closed_in", place.closed_in},
                 {"backface", place.backface ? Json(*place.backface) : Json()},
                 {"nearest_surface_m",
                  std::isfinite(place.nearest_surface_m) ? Json(place.nearest_surface_m) : Json()}};
    if (place.moved) {
        json["requested_position_m"] = {place.requested_m.x, place.requested_m.y,
                                        place.requested_m.z};
    }
    return json;
}

}  // namespace probebake
