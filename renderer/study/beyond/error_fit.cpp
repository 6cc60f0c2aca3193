#include "study/beyond/error_fit.h"

#include <cmath>

namespace probebake::study {
namespace {

constexpr int kRounds = 300;
/// Predictions are kept off zero by this share of the mean squared error: a pixel without any
/// evidence may err, if only a little. From 1e-6 to 1e-3 it makes no difference.
constexpr double kFloor = 1e-4;

using Terms = std::array<double, kErrorTerms>;

struct Observation {
    Terms terms{};
    double squared_error = 0.0;
    double weight = 0.0;
};

std::vector<Observation> observe(std::span<const std::vector<RecordedPixel>> scenes, int stage) {
    std::vector<Observation> all;
    for (const auto& pixels : scenes) {
        for (const RecordedPixel& pixel : pixels) {
            all.push_back({error_terms(stage, pixel.evidence), pixel.squared_error(stage),
                           1.0 / static_cast<double>(pixels.size())});
        }
    }
    return all;
}

Terms fit(const std::vector<Observation>& observations) {
    double mean_error = 0.0;
    double weight = 0.0;
    Terms scale{};
    for (const Observation& o : observations) {
        mean_error += o.weight * o.squared_error;
        weight += o.weight;
        for (size_t i = 0; i < kErrorTerms; ++i) scale[i] += o.weight * o.terms[i];
    }
    mean_error /= weight;
    Terms a{};
    int used = 0;
    for (const double s : scale) used += s > 0.0 ? 1 : 0;
    for (size_t i = 0; i < kErrorTerms; ++i) {
        if (scale[i] > 0.0) a[i] = mean_error * weight / (scale[i] * used);
    }
    for (int round = 0; round < kRounds; ++round) {
        Terms up{};
        Terms down{};
        for (const Observation& o : observations) {
            double p = kFloor * mean_error;
            for (size_t i = 0; i < kErrorTerms; ++i) p += a[i] * o.terms[i];
            for (size_t i = 0; i < kErrorTerms; ++i) {
                up[i] += o.weight * o.terms[i] * o.squared_error / (p * p);
                down[i] += o.weight * o.terms[i] / p;
            }
        }
        for (size_t i = 0; i < kErrorTerms; ++i) {
            if (down[i] > 0.0) a[i] *= std::sqrt(up[i] / down[i]);
        }
    }
    return a;
}

}  // namespace

ErrorModel fit_error_model(std::span<const std::vector<RecordedPixel>> scenes,
                           const ErrorModel& otherwise) {
    ErrorModel model = otherwise;
    for (int stage = 0; stage < kRecordedStages; ++stage) {
        model[static_cast<size_t>(stage)] = fit(observe(scenes, stage));
    }
    return model;
}

}  // namespace probebake::study
