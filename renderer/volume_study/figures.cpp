#include "volume_study/figures.h"

#include <cmath>

#include "image/preview.h"
#include "io/file.h"
#include "track/media_line.h"
#include "track/spectral.h"
#include "volume/phase.h"
#include "volume_study/cloud_picture.h"
#include "volume_study/test_media.h"

namespace probebake::volume_study {
namespace {

using study::decimals;

constexpr int kSamples = 16;
constexpr int kMostScatterings = 100'000;
/// Throughputs beyond this are as good as infinite: the path ends with what it has.
constexpr double kEndless = 1e100;
constexpr ToneCurve kTone{.exposure = 1.2, .shoulder = true};

/// A line whose majorants are f of what they ought to be.
class FactorLine {
  public:
    FactorLine(MediaLine<3>& line, double factor) : line_(line), factor_(factor) {}
    bool next(Segment<3>& segment) {
        if (!line_.next(segment)) return false;
        segment.most = segment.most * factor_;
        return true;
    }
    Coefficients<3> at(double t) { return line_.at(t); }

  private:
    MediaLine<3>& line_;
    double factor_;
};

/// Paths without roulette, splitting or surfaces: the sky at their ends.
template <Scheme S, bool Absorbs>
PathFunction paths(const Media& media, const Sky& sky, double factor) {
    return [&media, &sky, factor](const Ray& first, uint64_t key, PictureCost& cost) {
        RandomStream random(key);
        Ray ray = first;
        Spectrum<3> w(1.0);
        TrackCount count;
        Vec3 radiance(0.0);
        for (int i = 0;; ++i) {
            MediaLine<3> whole(media, ray, {});
            FactorLine line(whole, factor);
            const FlightEnd end = SpectralTracker<S>::template fly<TrackTraits<3, Absorbs, false>>(
                line, w, random, count, CollectNothing());
            cost.largest_weight = std::max(cost.largest_weight, w.max_abs());
            if (end.event == Event::kAbsorb) break;
            const bool endless = !(w.max_abs() < kEndless);
            if (end.event == Event::kEscape || endless) {
                radiance = to_vec3(w * to_spectrum(sky.radiance(ray.direction)));
                break;
            }
            if (i == kMostScatterings) {
                ++cost.faults;
                break;
            }
            ray.origin += ray.direction * end.t;
            const double cosine =
                sample_henyey_greenstein(media.all().front().spec.g, random.uniform());
            ray.direction = around(ray.direction, cosine, random.uniform());
        }
        cost.counted += count.lookups + count.leaves;
        cost.faults += count.faults;
        return radiance;
    };
}

Media chromatic_cloud(const Cloud& cloud, double column, double albedo) {
    const Rgb extinction(0.5f, 1.0f, 1.4f);
    const auto a = static_cast<float>(albedo);
    return Media({cloud_medium(cloud, column, extinction * (1.0f - a), extinction * a, /*g=*/0.0)},
                 {.max_depth = 6, .threshold = 0.2});
}

double largest_pixel(const CloudPicture& picture) {
    double most = 0.0;
    for (const Vec3& p : picture.pixels) {
        for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(p[c]));
    }
    return most;
}

void write_png(const std::filesystem::path& path, const Image& image) {
    write_file_atomically(path, encode_image_png(image, kTone));
}

std::string short_text(double x) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.3g", x);
    return text;
}

}  // namespace

study::TextTable unbounded_table(const Cloud& cloud, const FigureParams& params) {
    constexpr std::array<double, 6> kFactors = {1.0, 0.95, 0.9, 0.8, 0.7, 0.5};
    study::TextTable table;
    table.name = "figure_6";
    table.title = cloud.name + ", extinction .5:1:1.4, column 6, " + std::to_string(params.side) +
                  "² pixels of " + std::to_string(kSamples) +
                  " paths: free-path-sampling coefficients of f × the majorant (figure 6)";
    table.columns = {"albedo",
                     "f",
                     "RMSE",
                     "largest absolute pixel",
                     "largest absolute throughput",
                     "log10 of M lookups and leaves to unit variance",
                     "log10 of seconds to unit variance",
                     "faults"};
    const Lighting lighting = test_sky();
    std::vector<std::vector<CloudPicture>> pictures;
    const auto add = [&](double albedo, const Media& media, auto path) {
        const auto picture = [&](double factor, int samples, uint64_t key) {
            return render_picture(cloud, {.side = params.side, .samples = samples, .key = key},
                                  path(media, lighting.sky, factor));
        };
        const CloudPicture r1 = picture(1.0, params.reference, 61);
        const CloudPicture r2 = picture(1.0, params.reference, 62);
        pictures.emplace_back();
        for (const double factor : kFactors) {
            CloudPicture got = picture(factor, kSamples, 63);
            const double mse = squared_error(got, r1, r2);
            table.rows.push_back(
                {decimals(albedo, 1), decimals(factor, 2), short_text(std::sqrt(mse)),
                 short_text(largest_pixel(got)), short_text(got.cost.largest_weight),
                 decimals(std::log10(mse * static_cast<double>(got.cost.counted) * 1e-6), 2),
                 decimals(std::log10(mse * got.cost.seconds), 2),
                 std::to_string(got.cost.faults + r1.cost.faults + r2.cost.faults)});
            pictures.back().push_back(std::move(got));
        }
    };
    add(0.8, chromatic_cloud(cloud, 6.0, 0.8), paths<Scheme::kHistoryAverage, true>);
    add(1.0, chromatic_cloud(cloud, 6.0, 1.0), paths<Scheme::kHistoryAverage, false>);
    std::vector<std::vector<const CloudPicture*>> rows;
    for (const auto& row : pictures) {
        rows.emplace_back();
        for (const CloudPicture& picture : row) rows.back().push_back(&picture);
    }
    write_png(params.out / "figure_6.png", mosaic(rows, params.side, 4));
    return table;
}

study::TextTable schemes_table(const Cloud& cloud, const FigureParams& params) {
    study::TextTable table;
    table.name = "figure_7";
    table.title = cloud.name + ", extinction .5:1:1.4, albedo 1, column 100, " +
                  std::to_string(params.side) +
                  "² pixels: schemes of probabilities at equal cost (figure 7)";
    table.columns = {"scheme",        "paths per pixel", "M lookups and leaves", "CPU s", "RMSE",
                     "largest pixel", "off by > 1",      "largest throughput",   "faults"};
    const Media media = chromatic_cloud(cloud, 100.0, 1.0);
    const Lighting lighting = test_sky();
    const auto picture = [&](const PathFunction& path, int samples, uint64_t key) {
        return render_picture(cloud, {.side = params.side, .samples = samples, .key = key}, path);
    };
    const PathFunction average = paths<Scheme::kHistoryAverage, false>(media, lighting.sky, 1.0);
    const PathFunction maximum = paths<Scheme::kHistoryMax, false>(media, lighting.sky, 1.0);
    const CloudPicture r1 = picture(average, params.reference, 71);
    const CloudPicture r2 = picture(average, params.reference, 72);
    const CloudPicture by_average = picture(average, kSamples, 73);
    const CloudPicture tried = picture(maximum, kSamples, 74);
    const int equal = std::max(
        1, static_cast<int>(std::lround(kSamples * static_cast<double>(by_average.cost.counted) /
                                        static_cast<double>(tried.cost.counted))));
    const CloudPicture by_maximum = equal == kSamples ? tried : picture(maximum, equal, 74);
    const auto add = [&](const char* name, const CloudPicture& got, int samples) {
        size_t fireflies = 0;
        for (size_t i = 0; i < got.pixels.size(); ++i) {
            const Vec3 d = glm::abs(got.pixels[i] - 0.5 * (r1.pixels[i] + r2.pixels[i]));
            fireflies += std::max({d.x, d.y, d.z}) > 1.0 ? 1 : 0;
        }
        table.rows.push_back(
            {name, std::to_string(samples),
             decimals(static_cast<double>(got.cost.counted) * 1e-6, 2),
             decimals(got.cost.seconds, 2), decimals(std::sqrt(squared_error(got, r1, r2)), 4),
             decimals(largest_pixel(got), 2), std::to_string(fireflies),
             short_text(got.cost.largest_weight), std::to_string(got.cost.faults)});
    };
    add("history-aware maximum", by_maximum, equal);
    add("history-aware average", by_average, kSamples);
    write_png(params.out / "figure_7.png",
              mosaic({{&by_maximum, &by_average, &r1}}, params.side, 6));
    return table;
}

}  // namespace probebake::volume_study
