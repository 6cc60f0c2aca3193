// How much of something thinner than a pixel is left: the line's share of the picture, the torch's
// light.
//
// What is looked at is marked: voxels of the line with 1 and all others with 0, averaged up the
// levels as colours are; for the torch its emission. The sum of a small picture around it, over
// pictures shifted by parts of a pixel, is compared with the truth's: 1 means that nothing is lost
// and nothing added; "seen" is the share of the pictures that show anything of it. A level of
// detail thickens a line (thesis, 3.2.2); one ray per pixel on the leaves loses a torch (1.1).
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "error/node_error.h"
#include "study/experiments.h"

namespace probebake::study {
namespace {

constexpr int kView_px = 6;
constexpr double kHeight_px = 8.0;  // distance of the target in footprints
constexpr int kShifts = 1024;       // over a pixel: at 16 voxels per pixel four for each voxel
constexpr int kTruthGrid = 16;

struct Marked {
    ColorLevels levels;
    Vec3 target{0.0};  // voxels, in the middle of what is marked
    Vec3 forward{0.0, -1.0, 0.0};
    Vec3 up{0.0, 0.0, -1.0};
};

/// The marked voxel nearest to the mean position of all that are.
Vec3 middle_of(const VoxelTree& tree, const std::vector<PackedRgb>& marks) {
    std::vector<Vec3> positions;
    size_t i = 0;
    tree.for_each_voxel([&](const IVec3& p) {
        if (marks[i++] != 0) positions.push_back(Vec3(p) + 0.5);
    });
    if (positions.empty()) return Vec3(0.0);
    const Vec3 mean = std::accumulate(positions.begin(), positions.end(), Vec3(0.0)) /
                      static_cast<double>(positions.size());
    return *std::min_element(positions.begin(), positions.end(), [&](const Vec3& a, const Vec3& b) {
        return glm::distance(a, mean) < glm::distance(b, mean);
    });
}

/// The slackline is the one red thing of its scene.
Marked mark_line(const VoxelTree& tree) {
    const ColorLevels& albedo = tree.colors().albedo;
    std::vector<PackedRgb> marks(albedo.voxels.size(), 0);
    for (size_t i = 0; i < marks.size(); ++i) {
        const Rgb color = unpack_rgb(albedo.voxels[i]) * albedo.scale;
        if (color.r > 0.4f && color.r > 4.0f * color.g) marks[i] = pack_rgb(Rgb(1.0f));
    }
    Marked marked{.target = middle_of(tree, marks)};
    marked.levels = average_up(tree, std::move(marks), 1.0f);
    return marked;
}

/// The torch hangs before a wall that lies towards +Z.
Marked mark_torch(const VoxelTree& tree) {
    return {tree.colors().emission, middle_of(tree, tree.colors().emission.voxels),
            Vec3(0.0, 0.0, 1.0), Vec3(0.0, 1.0, 0.0)};
}

View view_of(const Marked& marked, double footprint, int shift) {
    const Vec3 right = glm::cross(marked.forward, marked.up);
    // The R2 sequence (Roberts 2018): on no lattice of the rays within a pixel.
    const double a = std::fmod(0.7548776662466927 * (shift + 1), 1.0) - 0.5;
    const double b = std::fmod(0.5698402909980532 * (shift + 1), 1.0) - 0.5;
    const Vec3 target = marked.target + footprint * (a * right + b * marked.up);
    const double half_angle = std::atan(0.5 * kView_px / kHeight_px);
    return perspective_view({.origin = target - footprint * kHeight_px * marked.forward,
                             .forward = marked.forward,
                             .up = marked.up,
                             .vertical_fov_degrees = 360.0 / std::numbers::pi * half_angle,
                             .width_px = kView_px,
                             .height_px = kView_px});
}

double sum_of(const ViewRecord& record, const Outcome& outcome) {
    double sum = 0.0;
    for (const PixelRecord& pixel : record.pixels) sum += outcome(pixel).color.r;
    return sum;
}

}  // namespace

Json run_thin(const ExperimentInput& input) {
    const VoxelTree& tree = input.work.scene().tree;
    const Marked marked =
        input.work.study_scene().name == "torch" ? mark_torch(tree) : mark_line(tree);
    const RenderScene scene{.tree = tree, .color = marked.levels};
    const std::pair<const char*, Outcome> renderers[] = {
        {"reference", reference_outcome},
        {"lod", lod_outcome},
        {"error_aware",
         [](const PixelRecord& p) {
             return error_aware_outcome(p, kThesisThreshold, kThesisDecay);
         }},
        {"error_aware_decay_1",
         [](const PixelRecord& p) { return error_aware_outcome(p, kThesisThreshold, 1.0); }},
    };
    Json rows = Json::array();
    for (const double footprint : {1.0, 2.0, 4.0, 8.0, 16.0}) {
        std::vector<ViewRecord> records(kShifts);
        std::vector<double> truths(kShifts);
        tbb::parallel_for(0, kShifts, [&](int shift) {
            const auto s = static_cast<size_t>(shift);
            records[s] = record_view(scene, view_of(marked, footprint, shift));
            CostStats uncounted;
            for (int y = 0; y < kView_px; ++y) {
                for (int x = 0; x < kView_px; ++x) {
                    truths[s] +=
                        uniform_pixel(scene, records[s].view, x, y, kTruthGrid, uncounted).color.r;
                }
            }
        });
        const double truth = std::accumulate(truths.begin(), truths.end(), 0.0);
        Json row = {{"footprint_voxels", footprint}};
        for (const auto& [name, outcome] : renderers) {
            double sum = 0.0;
            uint64_t rays = 0;
            int seen = 0;
            for (const ViewRecord& record : records) {
                const double of_view = sum_of(record, outcome);
                sum += of_view;
                seen += of_view > 0.0 ? 1 : 0;
                for (const PixelRecord& pixel : record.pixels) {
                    const PixelOutcome cast = outcome(pixel);
                    rays += cast.kept_rays + cast.discarded_rays;
                }
            }
            row[name] = {
                {"kept", sum / truth},
                {"seen", seen / double{kShifts}},
                {"rays_per_pixel", static_cast<double>(rays) / (kShifts * kView_px * kView_px)}};
        }
        rows.push_back(std::move(row));
    }
    return {{"rows", std::move(rows)}};
}

}  // namespace probebake::study
