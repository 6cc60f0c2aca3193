#include <cmath>

#include "error/node_error.h"
#include "image/exposure.h"
#include "image/preview.h"
#include "io/file.h"
#include "study/experiments.h"

namespace probebake::study {
namespace {

PixelOutcome thesis_outcome(const PixelRecord& pixel) {
    return error_aware_outcome(pixel, kThesisThreshold, kThesisDecay);
}

Outcome adaptive(double normaliser, MissesInKernel misses) {
    return [normaliser, misses](const PixelRecord& pixel) {
        return adaptive_outcome(pixel, normaliser, misses);
    };
}

/// Grey by the logarithm of the rays of a pixel, 1 black and 21 white; pixels without any hit too.
Image ray_map(const ViewRecord& record, const Outcome& outcome) {
    Image map(record.view.width_px, record.view.height_px);
    for (size_t i = 0; i < record.pixels.size(); ++i) {
        const PixelOutcome pixel = outcome(record.pixels[i]);
        const double rays = pixel.kept_rays + pixel.discarded_rays;
        map.pixels()[i] = count_grey(rays, 21.0);
    }
    return map;
}

}  // namespace

Json measure_renderers(const RecordSet& set, const GlobalNormalisers& normalisers) {
    Json rows = Json::array();
    const auto add = [&](const char* renderer, const Outcome& outcome,
                         std::optional<double> normaliser = {}) {
        Json row = write_measured(set.measure(outcome));
        row["renderer"] = renderer;
        if (normaliser) row["normaliser"] = *normaliser;
        rows.push_back(std::move(row));
    };
    add("reference", reference_outcome);
    add("lod", lod_outcome);
    add("error_aware", thesis_outcome);
    const uint64_t steps = set.count(thesis_outcome).steps;
    const auto add_adaptive = [&](const char* renderer, double normaliser, MissesInKernel misses) {
        add(renderer, adaptive(normaliser, misses), normaliser);
    };
    add_adaptive("adaptive", set.normaliser_for_steps(steps, MissesInKernel::kLeftOut),
                 MissesInKernel::kLeftOut);
    add_adaptive("adaptive_black", set.normaliser_for_steps(steps, MissesInKernel::kBlack),
                 MissesInKernel::kBlack);
    if (normalisers.desert) {
        add_adaptive("adaptive_desert", *normalisers.desert, MissesInKernel::kLeftOut);
    }
    if (normalisers.largest) {
        add_adaptive("adaptive_global", *normalisers.largest, MissesInKernel::kLeftOut);
    }
    return rows;
}

Json measure_normaliser(SceneWork& work) {
    const RecordSet& set = work.nadir();
    return {{"largest_variation", set.largest_variation()},
            {"solved",
             set.normaliser_for_steps(set.count(thesis_outcome).steps, MissesInKernel::kLeftOut)}};
}

Json run_rendering(const ExperimentInput& input) {
    const Scene& scene = input.work.scene();
    const RecordSet& set = input.work.nadir();
    const View& view = set.views()[0].view;
    Json result = {
        {"voxels", scene.tree.voxel_count()},
        {"octree_nodes", scene.tree.octree_node_count()},
        {"view_px", view.width_px},
        {"origin", {view.origin.x, view.origin.y, view.origin.z}},
        {"renderers", measure_renderers(set, input.normalisers)},
    };
    const auto save = [&](const std::string& what, const Image& image, const ToneCurve& tone) {
        const std::string name = input.work.study_scene().name + "-" + what + ".png";
        write_file_atomically(input.picture_folder / name, encode_image_png(image, tone));
        result["pictures"].push_back(name);
    };
    const double brightest = exposure_of(set.truth()[0].pixels());
    save("view", set.image(0, reference_outcome), {.exposure = brightest, .shoulder = true});
    // The maps at the thesis's cost: at its settings they are nearly white.
    const auto steps =
        static_cast<uint64_t>(kThesisBudget * static_cast<double>(set.count(lod_outcome).steps));
    const double threshold = set.threshold_for_steps(steps, kThesisDecay);
    save("error-aware-rays",
         ray_map(set.views()[0],
                 [&](const PixelRecord& pixel) {
                     return error_aware_outcome(pixel, threshold, kThesisDecay);
                 }),
         {});
    save("adaptive-rays",
         ray_map(set.views()[0], adaptive(set.normaliser_for_steps(steps, MissesInKernel::kLeftOut),
                                          MissesInKernel::kLeftOut)),
         {});
    return result;
}

}  // namespace probebake::study
