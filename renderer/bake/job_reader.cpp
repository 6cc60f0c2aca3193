// read_job: the JSON of a request, field by field.
#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "bake/ddgi.h"
#include "bake/job_names.h"
#include "bake/job_spec.h"
#include "bake/state_json.h"
#include "image/cubemap.h"
#include "image/ssim.h"
#include "voxels/voxel_tree.h"

namespace probebake {
namespace {

class JobReader {
  public:
    JobReader(const Json& request, const JobLimits& limits)
        : limits_(limits), request_(request), root_(request, "", issues_) {}

    JobSpec read() {
        spec_.scene = root_.name("scene", std::nullopt);
        read_states();
        spec_.seed = root_.unsigned_integer("seed", std::numeric_limits<uint64_t>::max(), 1);
        read_probe_defaults();
        read_probes();
        read_validity();
        read_products();
        read_quality();
        read_budget();
        spec_.priority = static_cast<int>(
            root_.integer("priority", -limits_.max_priority, limits_.max_priority, 0));
        root_.refuse_unknown();
        if (issues_.empty()) check_totals();
        if (issues_.empty() && spec_.products.ddgi) check_ddgi();
        issues_.throw_if_any();
        return std::move(spec_);
    }

  private:
    void read_states() {
        if (!root_.has("lighting_states")) {
            root_.array("lighting_states", 0);
            return;
        }
        spec_.states.clear();
        for (const auto& [value, pointer] : root_.array("lighting_states", limits_.max_states)) {
            LightingState state = read_state(*value, pointer, issues_);
            const bool known =
                std::any_of(spec_.states.begin(), spec_.states.end(),
                            [&](const LightingState& other) { return other.id == state.id; });
            if (known && issues_.empty()) {
                issues_.unacceptable(pointer, "the state \"" + state.id + "\" is named twice");
            }
            spec_.states.push_back(std::move(state));
        }
        if (spec_.states.empty() && issues_.empty()) {
            issues_.unacceptable("/lighting_states", "expected at least one state");
        }
    }

    void read_probe_defaults() { read_view(root_, default_probe_); }

    /// face_size_px, near_m and far_m, of a probe, a grid or the whole job.
    void read_view(ObjectReader& reader, ProbeSpec& probe) {
        probe.face_size_px =
            static_cast<int>(reader.integer("face_size_px", limits_.min_face_size_px,
                                            limits_.max_face_size_px, probe.face_size_px));
        probe.near_m = reader.number("near_m", {0.0, limits_.max_position_m}, probe.near_m);
        if (const auto far_m =
                reader.optional_number("far_m", {.min = 0.0, .max = 1e9, .more_than_min = true})) {
            probe.far_m = far_m;
        }
        if (probe.far_m && !(*probe.far_m > probe.near_m)) {
            issues_.unacceptable(reader.pointer_to("far_m"), "expected more than near_m");
        }
    }

    void read_probes() {
        if (!root_.has("probes")) {
            issues_.malformed("/probes", "is required");
            root_.object("probes");
            return;
        }
        ObjectReader probes = root_.object("probes");
        for (const auto& [value, pointer] : probes.array("list", limits_.max_probes)) {
            ObjectReader reader(*value, pointer, issues_);
            ProbeSpec probe = default_probe_;
            probe.id = reader.name("id", std::nullopt);
            probe.position_m = reader.vector("position_m", limits_.max_position_m, std::nullopt);
            read_view(reader, probe);
            reader.refuse_unknown();
            add(std::move(probe), reader.pointer_to("id"));
        }
        for (const auto& [value, pointer] : probes.array("grids", 1024)) {
            ObjectReader reader(*value, pointer, issues_);
            read_grid(reader);
        }
        probes.refuse_unknown();
        if (spec_.probes.empty() && issues_.empty()) {
            issues_.unacceptable("/probes", "expected at least one probe in list or grids");
        }
    }

    void read_grid(ObjectReader& reader) {
        ProbeSpec probe = default_probe_;
        const std::string id = reader.name("id", std::nullopt);
        const Vec3 origin_m = reader.vector("origin_m", limits_.max_position_m, std::nullopt);
        const Vec3 spacing_m = reader.vector("spacing_m", limits_.max_position_m, std::nullopt);
        const Vec3 counts = reader.vector("counts", 1e9, std::nullopt);
        read_view(reader, probe);
        reader.refuse_unknown();
        for (int axis = 0; axis < 3; ++axis) {
            const std::string pointer = reader.pointer_to("counts") + "/" + std::to_string(axis);
            if (!(counts[axis] >= 1.0) || counts[axis] != std::floor(counts[axis])) {
                issues_.unacceptable(pointer, "expected an integer of at least 1");
                return;
            }
        }
        // In floating point on purpose: it cannot overflow, and is exact where it matters.
        if (counts.x * counts.y * counts.z >
            static_cast<double>(limits_.max_probes - spec_.probes.size())) {
            issues_.unacceptable(
                reader.pointer_to("counts"),
                "the job would have more than " + std::to_string(limits_.max_probes) + " probes");
            return;
        }
        for (int axis = 0; axis < 3; ++axis) {
            const double last_m = origin_m[axis] + spacing_m[axis] * (counts[axis] - 1.0);
            if (!(std::abs(last_m) <= limits_.max_position_m)) {
                issues_.unacceptable(reader.pointer_to("spacing_m") + "/" + std::to_string(axis),
                                     "the grid reaches farther than the largest coordinate");
                return;
            }
        }
        const IVec3 count(counts);
        spec_.grids.push_back({id, origin_m, spacing_m, count, spec_.probes.size()});
        for (int k = 0; k < count.z; ++k) {
            for (int j = 0; j < count.y; ++j) {
                for (int i = 0; i < count.x; ++i) {
                    probe.id = id + "-" + std::to_string(i) + "-" + std::to_string(j) + "-" +
                               std::to_string(k);
                    probe.position_m = origin_m + spacing_m * Vec3(i, j, k);
                    if (!add(probe, reader.pointer_to("id"))) return;
                }
            }
        }
    }

    bool add(ProbeSpec probe, const std::string& id_pointer) {
        if (!is_name(probe.id)) {
            issues_.unacceptable(id_pointer,
                                 "gives the probe id \"" + probe.id + "\", which is no valid name");
            return false;
        }
        if (!ids_.insert(probe.id).second) {
            issues_.unacceptable(id_pointer, "the probe id \"" + probe.id + "\" is used twice");
            return false;
        }
        if (spec_.probes.size() == limits_.max_probes) {
            issues_.unacceptable(id_pointer, "the job would have more than " +
                                                 std::to_string(limits_.max_probes) + " probes");
            return false;
        }
        spec_.probes.push_back(std::move(probe));
        return true;
    }

    void read_validity() {
        if (!root_.has("validity")) {
            root_.object("validity");
            return;
        }
        ObjectReader reader = root_.object("validity");
        ValiditySpec& validity = spec_.validity.emplace();
        PlaceRules& rules = validity.rules;
        rules.max_backface = reader.number("max_backface", {0.0, 1.0}, rules.max_backface);
        rules.max_closed_in = reader.number("max_closed_in", {0.0, 1.0}, rules.max_closed_in);
        validity.relocate = reader.boolean("relocate", validity.relocate);
        validity.max_offset_m =
            reader.number("max_offset_m", {0.0, limits_.max_position_m}, validity.max_offset_m);
        if (validity.max_offset_m > 0.0 && !validity.relocate) {
            issues_.unacceptable(reader.pointer_to("max_offset_m"),
                                 "moves nothing: expected \"relocate\": true with it");
        }
        reader.refuse_unknown();
    }

    void read_products() {
        if (!root_.has("products")) {
            root_.array("products", 0);
            return;
        }
        spec_.products.cube = false;
        bool any = false;
        for (const auto& [value, pointer] : root_.array("products", kProductNames.size())) {
            const std::string name = read_name(*value, pointer, issues_);
            const auto at = std::find(kProductNames.begin(), kProductNames.end(), name);
            if (at == kProductNames.end()) {
                issues_.unacceptable(pointer, "expected one of " + product_names());
                continue;
            }
            spec_.products.*kProductFlags[static_cast<size_t>(at - kProductNames.begin())] = true;
            any = true;
        }
        if (!any) issues_.unacceptable("/products", "expected at least one of " + product_names());
    }

    static std::string product_names() {
        std::string names;
        for (const std::string_view name : kProductNames) {
            names.append(names.empty() ? "\"" : ", \"").append(name).append("\"");
        }
        return names;
    }

    /// Nothing but spherical harmonics: irradiance is what they are for.
    bool only_sh() const {
        const Products& products = spec_.products;
        return products.sh &&
               std::count_if(kProductFlags.begin(), kProductFlags.end(),
                             [&](bool Products::*flag) { return products.*flag; }) == 1;
    }

    void read_quality() {
        ObjectReader reader = root_.object("quality");
        read_target(reader);
        const size_t renderer =
            reader.choice("renderer", kRendererNames, kRendererNames.size() - 1);
        if (renderer + 1 < kRendererNames.size()) {
            spec_.quality.renderer = static_cast<RendererKind>(renderer);
        }
        read_tracker(reader);
        spec_.quality.against = static_cast<Against>(reader.choice("against", kAgainstNames, 0));
        spec_.quality.weighting =
            static_cast<Weighting>(reader.choice("weighting", kWeightingNames, 0));
        spec_.quality.exposure =
            reader.optional_number("exposure", {.min = 0.0, .max = 1e9, .more_than_min = true});
        read_settings(reader);
        const std::optional<RendererKind>& renderer_kind = spec_.quality.renderer;
        if (wants_leaf_rays_only(spec_) && renderer_kind &&
            *renderer_kind != RendererKind::kReference) {
            issues_.unacceptable("/quality/renderer",
                                 "irradiance_rel is reached by leaf rays: expected \"auto\" or "
                                 "\"reference\", or settings of your own");
        }
        read_evidence(reader);
        reader.refuse_unknown();
    }

    void read_target(ObjectReader& quality) {
        ObjectReader targets = quality.object("targets");
        std::vector<QualityTarget> given;
        const auto take = [&](QualityTarget::Metric metric, std::optional<double> value) {
            if (value) given.push_back({metric, *value});
        };
        take(QualityTarget::Metric::kPsnrDb,
             targets.optional_number("psnr_db", {.min = 0.0, .max = 200.0, .more_than_min = true}));
        take(QualityTarget::Metric::kRmse,
             targets.optional_number("rmse", {.min = 0.0, .max = 1.0, .more_than_min = true}));
        take(QualityTarget::Metric::kSsim,
             targets.optional_number("ssim", {.min = 0.0, .max = 1.0, .more_than_min = true}));
        take(QualityTarget::Metric::kIrradianceRel,
             targets.optional_number("irradiance_rel",
                                     {.min = 0.0, .max = 1.0, .more_than_min = true}));
        take(QualityTarget::Metric::kRelMse,
             targets.optional_number("rel_mse", {.min = 0.0, .max = 1.0, .more_than_min = true}));
        const uint64_t rays = targets.unsigned_integer("rays", limits_.max_rays, 0);
        if (targets.has("rays")) take(QualityTarget::Metric::kRays, static_cast<double>(rays));
        targets.refuse_unknown();
        spec_.quality.require = static_cast<Require>(quality.choice("require", kRequireNames, 0));
        if (given.size() > 1 && targets.has("rays")) {
            issues_.unacceptable("/quality/targets/rays",
                                 "a number of rays is a target of its own: expected no other");
        }
        if (!given.empty()) {
            spec_.quality.targets = std::move(given);
        } else if (only_sh()) {
            spec_.quality.targets = {
                {QualityTarget::Metric::kIrradianceRel, kDefaultIrradianceRel}};
        }
    }

    /// All but "none", which renders nothing.
    void read_tracker(ObjectReader& quality) {
        std::array<std::string_view, kTrackerKinds> names{"auto"};
        for (size_t i = 1; i < names.size(); ++i) names[i] = name_of(static_cast<TrackerKind>(i));
        const size_t tracker = quality.choice("tracker", names, 0);
        if (tracker > 0) spec_.quality.tracker = static_cast<TrackerKind>(tracker);
    }

    void read_settings(ObjectReader& quality) {
        if (!quality.has("settings")) {
            quality.object("settings");
            return;
        }
        ObjectReader reader = quality.object("settings");
        RenderSettings settings;
        settings.threshold = reader.number("threshold", {-1.0, 1e6}, settings.threshold);
        settings.decay = reader.number("decay", {0.0, 10.0}, settings.decay);
        const bool hybrid = spec_.quality.renderer == RendererKind::kHybrid;
        const int64_t grid = reader.integer("leaf_grid", 4, 16, hybrid ? 16 : 4);
        if (grid != 4 && grid != 8 && grid != 16) {
            issues_.unacceptable(reader.pointer_to("leaf_grid"), "expected 4, 8 or 16");
        }
        settings.leaf_grid = static_cast<int>(grid);
        settings.price = reader.number("price", {-1.0, 1e12}, settings.price);
        settings.spread = reader.optional_number("spread", {0.0, 1e9}).value_or(settings.spread);
        if (reader.has("fixed_level")) {
            settings.fixed_level =
                static_cast<int>(reader.integer("fixed_level", 0, kMaxDepth - 1, 0));
        }
        settings.normaliser = reader.number(
            "normaliser", {.min = 0.0, .max = 1e6, .more_than_min = true}, settings.normaliser);
        settings.misses_in_kernel =
            static_cast<MissesInKernel>(reader.choice("misses_in_kernel", kMissesNames, 0));
        reader.refuse_unknown();
        if (!spec_.quality.renderer) {
            issues_.unacceptable("/quality/settings",
                                 "settings of your own need a renderer of your own");
        } else {
            settings.kind = *spec_.quality.renderer;
        }
        spec_.quality.settings = settings;
    }

    void read_evidence(ObjectReader& quality) {
        const Json::json_pointer place("/quality/evidence");
        if (request_.contains(place) && request_.at(place).is_string()) {
            constexpr std::string_view kNone[] = {"none"};
            quality.choice("evidence", kNone, std::nullopt);
            spec_.quality.evidence.audit = false;
            return;
        }
        ObjectReader reader = quality.object("evidence");
        EvidenceSpec& evidence = spec_.quality.evidence;
        evidence.audit = reader.boolean("audit", true);
        if (reader.has("pixels_per_probe")) {
            evidence.pixels_per_probe = static_cast<int>(
                reader.integer("pixels_per_probe", 16, limits_.max_audit_pixels, 64));
        }
        evidence.confidence = reader.number("confidence", {0.5, 0.9999}, evidence.confidence);
        reader.refuse_unknown();
    }

    void read_budget() {
        ObjectReader reader = root_.object("budget");
        if (reader.has("rays")) {
            spec_.budget.rays = reader.unsigned_integer("rays", limits_.max_rays, {});
        }
        spec_.budget.seconds =
            reader.optional_number("seconds", {.min = 0.0, .max = 1e7, .more_than_min = true});
        if (reader.has("memory_bytes")) {
            spec_.budget.memory_bytes =
                reader.unsigned_integer("memory_bytes", limits_.max_memory_bytes, {});
        }
        reader.refuse_unknown();
        spec_.on_budget_exhausted = static_cast<OnBudgetExhausted>(
            root_.choice("on_budget_exhausted", kOnBudgetExhaustedNames, 0));
    }

    /// What only the whole job shows.
    void check_totals() {
        const uint64_t texels = texel_count(spec_);
        if (texels > limits_.max_texels) {
            issues_.unacceptable("/probes", "the job has " + std::to_string(texels) +
                                                " texels, expected at most " +
                                                std::to_string(limits_.max_texels));
        }
        const uint64_t largest = largest_probe_pixels();
        const QualitySpec& quality = spec_.quality;
        if (only_target(quality, QualityTarget::Metric::kRays) &&
            quality.targets.front().value < static_cast<double>(largest)) {
            issues_.unacceptable("/quality/targets/rays", "expected at least one ray per pixel, " +
                                                              std::to_string(largest) +
                                                              " for the largest probe");
        }
        if (has_target(quality, QualityTarget::Metric::kSsim) &&
            smallest_face_px() < kSsimWindow_px) {
            issues_.unacceptable("/quality/targets/ssim",
                                 "SSIM is not defined below a face size of 11 pixels");
        }
        if (spec_.budget.rays && *spec_.budget.rays < pixel_count(spec_)) {
            issues_.unacceptable("/budget/rays", "expected at least one ray per pixel, " +
                                                     std::to_string(pixel_count(spec_)));
        }
    }

    /// An atlas is that of a grid, and an engine must be able to load it.
    void check_ddgi() {
        if (spec_.grids.empty() || spec_.grids[0].first_probe > 0) {
            issues_.unacceptable("/probes/list",
                                 "the product \"ddgi\" is an atlas of a grid: expected probes in "
                                 "grids alone");
            return;
        }
        for (size_t g = 0; g < spec_.grids.size(); ++g) {
            const ProbeGrid& grid = spec_.grids[g];
            const std::string pointer = "/probes/grids/" + std::to_string(g);
            for (int axis = 0; axis < 3; ++axis) {
                if (grid.spacing_m[axis] > 0.0) continue;
                issues_.unacceptable(pointer + "/spacing_m/" + std::to_string(axis),
                                     "the product \"ddgi\" expects more than 0");
            }
            const double tile = ddgi_tile_px(kDdgiDistance_px);
            const double width = tile * grid.counts.x * grid.counts.y;
            const double height = tile * grid.counts.z;
            if (std::max(width, height) > limits_.max_atlas_px) {
                issues_.unacceptable(pointer + "/counts",
                                     "the atlas of distances would be more than " +
                                         std::to_string(limits_.max_atlas_px) +
                                         " texels wide (16 x y) or high (16 z)");
            }
            if (ids_.contains(grid.id)) {
                issues_.unacceptable(pointer + "/id",
                                     "is the id of a probe, too: their files would share a folder");
            }
        }
    }

    uint64_t largest_probe_pixels() const {
        int n = 1;
        for (const ProbeSpec& probe : spec_.probes) n = std::max(n, probe.face_size_px);
        return owned_pixel_count(n);
    }
    int smallest_face_px() const {
        int n = std::numeric_limits<int>::max();
        for (const ProbeSpec& probe : spec_.probes) n = std::min(n, probe.face_size_px);
        return n;
    }

    JobLimits limits_;
    const Json& request_;
    JsonIssues issues_;
    ObjectReader root_;
    JobSpec spec_;
    ProbeSpec default_probe_;
    std::unordered_set<std::string> ids_;
};

}  // namespace

JobSpec read_job(const Json& request, const JobLimits& limits) {
    return JobReader(request, limits).read();
}

}  // namespace probebake
