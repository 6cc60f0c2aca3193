#include "bake/hidden_light.h"

#include <algorithm>
#include <cmath>

#include "math/random.h"

namespace probebake {
namespace {

/// Per side of a pixel, parts whose sky is compared with it.
constexpr int kParts = 2;

double squared_difference(const Rgb& a, const Rgb& b) {
    const Vec3 d = Vec3(a) - Vec3(b);
    return glm::dot(d, d) / 3.0;
}

bool has_emitters(const EmitterSampler* emitters) {
    return emitters != nullptr && !emitters->empty();
}

bool has_picture(const RenderScene& scene) {
    return scene.sky != nullptr && scene.sky->texels() > 0;
}

class Search {
  public:
    Search(const HiddenLightSpec& spec, CostStats& cost)
        : spec_(spec), cost_(cost), n_(spec.as_written.face_size()) {}

    std::vector<double> run() {
        if (has_emitters(spec_.emitters)) look_at_emitters();
        if (has_picture(spec_.scene)) look_at_sky();
        if (found_.empty()) return {};
        ask_neighbours();
        for_each_shared_pixel(n_, [&](const CubePixel& pixel, const CubePixel& owner) {
            found_[cube_index(pixel, n_)] = found_[cube_index(owner, n_)];
        });
        return std::move(found_);
    }

  private:
    RandomStream random(uint64_t what) const { return RandomStream(random_key({spec_.key, what})); }

    /// The leaf that a ray meets, and what it shows of it.
    std::pair<Hit, Rgb> see(const Vec3& direction) {
        Hit hit = trace(spec_.scene.tree, {spec_.origin, direction}, {}, spec_.scene.range);
        const Rgb seen = shade(spec_.scene, direction, hit);
        cost_.keep(hit);
        return {hit, seen};
    }

    /// Gaps are longer than a pixel more often than not: no less than the mean of the neighbours.
    void ask_neighbours() {
        const std::vector<double> own = found_;
        for (size_t i = 0; i < own.size(); ++i) {
            const CubePixel pixel = pixel_at(i, n_);
            double sum = 0.0;
            int count = 0;
            for (int y = std::max(0, pixel.y - 1); y <= std::min(n_ - 1, pixel.y + 1); ++y) {
                for (int x = std::max(0, pixel.x - 1); x <= std::min(n_ - 1, pixel.x + 1); ++x) {
                    sum += own[cube_index({pixel.face, x, y}, n_)];
                    ++count;
                }
            }
            found_[i] = std::max(own[i], sum / count);
        }
    }

    CubePixel owner_towards(const FacePoint& at) const {
        const auto pixel = [&](double u) {
            return std::clamp(static_cast<int>(std::lround((u * (n_ - 1) + n_ - 1) / 2.0)), 0,
                              n_ - 1);
        };
        return owner_of({at.face, pixel(at.u), pixel(at.v)}, n_);
    }

    void add(const CubePixel& owner, const Rgb& seen, double weight) {
        if (found_.empty()) found_.resize(6 * static_cast<size_t>(n_) * static_cast<size_t>(n_));
        found_[cube_index(owner, n_)] +=
            weight * squared_difference(seen, spec_.as_written.at(owner));
    }

    void look_at_emitters() {
        RandomStream random = this->random(0);
        for (int i = 0; i < spec_.emitter_rays; ++i) {
            const auto sample = spec_.emitters->sample(
                spec_.origin, {random.uniform(), random.uniform(), random.uniform()});
            if (!sample) continue;
            const Vec3 to = sample->point - spec_.origin;
            const double distance = glm::length(to);
            if (!(distance > 0.0)) continue;
            const Vec3 direction = to / distance;
            const auto [hit, seen] = see(direction);
            if (!hit || hit.corner != sample->corner) continue;  // something is before it
            const double cosine = std::max(1e-6, std::abs(direction[axis_of(sample->face)]));
            // Per area of the face's plane, over which a pixel is a mean.
            const FacePoint at = face_point(direction);
            const double density = EmitterSampler::density(sample->probability, distance, cosine) /
                                   std::pow(1.0 + at.u * at.u + at.v * at.v, 1.5);
            const double spacing = grid_spacing(n_);
            add(owner_towards(at), seen, 1.0 / (spec_.emitter_rays * density * spacing * spacing));
        }
    }

    void look_at_sky() {
        RandomStream random = this->random(1);
        struct Part {  // of a pixel
            CubePixel owner;
            Vec2 corner{0.0};  // in pixels
        };
        std::vector<Part> parts;
        std::vector<double> cumulative;
        double sum = 0.0;
        const auto direction_in = [&](const Part& part) {
            const Vec2 at = part.corner + Vec2(random.uniform(), random.uniform()) / double{kParts};
            return glm::normalize(face_direction(part.owner.face, grid_coordinate(at.x, n_),
                                                 grid_coordinate(at.y, n_)));
        };
        const size_t count = 6 * static_cast<size_t>(n_) * static_cast<size_t>(n_);
        for (size_t i = 0; i < count; ++i) {
            const CubePixel pixel = pixel_at(i, n_);
            if (!(owner_of(pixel, n_) == pixel)) continue;
            for (int k = 0; k < kParts * kParts; ++k) {
                const Vec2 place = Vec2(k % kParts, k / kParts) / double{kParts} - Vec2(0.5);
                parts.push_back({pixel, Vec2(pixel.x, pixel.y) + place});
                const Rgb behind = spec_.scene.sky->radiance(direction_in(parts.back()));
                sum += squared_difference(behind, spec_.as_written.at(pixel)) *
                       pixel_solid_angle(pixel.x, pixel.y, n_);
                cumulative.push_back(sum);
            }
        }
        if (!(sum > 0.0)) return;
        for (int i = 0; i < spec_.rays; ++i) {
            const auto at =
                std::upper_bound(cumulative.begin(), cumulative.end(), random.uniform() * sum);
            const auto which =
                std::min(static_cast<size_t>(at - cumulative.begin()), parts.size() - 1);
            const double drawn =
                (cumulative[which] - (which > 0 ? cumulative[which - 1] : 0.0)) / sum;
            if (!(drawn > 0.0)) continue;
            const auto [hit, seen] = see(direction_in(parts[which]));
            if (hit) continue;
            add(parts[which].owner, seen, 1.0 / (drawn * spec_.rays * kParts * kParts));
        }
    }

    const HiddenLightSpec& spec_;
    CostStats& cost_;
    int n_;
    std::vector<double> found_;
};

}  // namespace

std::shared_ptr<const EmitterSampler> emitters_to_look_for(const Scene& scene,
                                                           const LightingState& state) {
    if (state.kind != LightingState::Kind::kEmission || !scene.emits()) return nullptr;
    return std::make_shared<const EmitterSampler>(scene.tree);
}

bool may_hide_light(const RenderScene& scene, const EmitterSampler* emitters) {
    return has_emitters(emitters) || has_picture(scene);
}

std::vector<double> hidden_light(const HiddenLightSpec& spec, CostStats& cost) {
    return Search(spec, cost).run();
}

}  // namespace probebake
