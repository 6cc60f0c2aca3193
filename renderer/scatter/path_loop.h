// The path loop of path_tracer.h, as a template on tracker and traits, and on whether rays go to
// emissive voxels.
#pragma once

#include <numbers>

#include "scatter/path_tracer.h"
#include "track/media_line.h"
#include "track/spectral_mis.h"
#include "track/transmittance.h"
#include "volume/phase.h"
#include "voxels/trace.h"

namespace probebake {

/// Where a path goes on from, in both spaces: exact on a voxel's face.
struct PathPlace {
    Vec3 voxels{0.0};
    Vec3 metres{0.0};
};

/// What scatters there: a phase function, or a Lambert surface with that normal.
struct Scatterer {
    bool surface = false;
    double g = 0.0;
    Vec3 normal{0.0};

    /// Radiance out per irradiance that arrives along −`towards`, without albedo; the density of
    /// sample() too.
    double value(const Vec3& from, const Vec3& towards) const {
        if (!surface) return henyey_greenstein(g, glm::dot(from, towards));
        return std::max(0.0, glm::dot(normal, towards)) / std::numbers::pi;
    }
    template <class Random>
    Vec3 sample(const Vec3& from, Random& random) const {
        const double u = random.uniform();
        const double turn = random.uniform();
        if (!surface) return around(from, sample_henyey_greenstein(g, u), turn);
        return around(normal, std::sqrt(1.0 - u), turn);
    }
};

/// In the place of a tracker, for media that do not scatter: paths pass them, weighed by the
/// transmittance, and collect what they emit.
struct Unscattered {
    static constexpr bool kScalar = true;
    static constexpr bool kDecomposes = false;
};

template <class Tracker, class Traits, bool Emitters>
class PathLoop {
  public:
    static constexpr int N = Traits::kChannels;
    static constexpr bool kPasses = std::is_same_v<Tracker, Unscattered>;

    PathLoop(const PathTracer& tracer, PathRandom& random, PathCount& count)
        : tracer_(tracer), scene_(tracer.scene()), random_(random), count_(count) {}

    PathResult run(const Ray& ray_m, TRange range) {
        ++count_.paths;
        PathPlace at{to_voxels(ray_m.origin), ray_m.origin};
        Vec3 direction = ray_m.direction;
        bool first = true;
        bool from_surface = false;
        double density = 0.0;  // of the direction; 0: the camera's own
        for (int scatterings = 0;; ++scatterings) {
            if (scatterings >= tracer_.settings().most_scatterings) {
                ++count_.faults;
                break;
            }
            const Hit hit = trace_voxels(at, direction, range);
            const double end = hit ? hit.t * scene_.voxel_size_m : range.end;
            MediaLine<N> line(scene_.media, {at.metres, direction}, {range.begin, end});
            FlightEnd flight;
            if constexpr (kPasses && !Traits::kEmits) {
                beta_ *= transmittance(at, direction, {range.begin, end});
            } else if constexpr (kPasses) {
                collect_and_pass(line);
            } else {
                flight = fly(line);
            }
            count_.flights.faults += line.unbounded();
            Scatterer scatterer;
            PathPlace next;
            if (flight.event == Event::kEscape) {
                if (!hit) {
                    add_sky(direction, density);
                    count_.misses += first ? 1 : 0;
                    break;
                }
                if (first) result_.distance_m = end;
                if (from_surface) break;
                next = surface_place(hit);
                scatterer = meet_surface(hit, at, direction, density);
                from_surface = true;
            } else {
                if (first) result_.distance_m = flight.t;
                if (flight.event == Event::kAbsorb) break;
                next.metres = at.metres + direction * flight.t;
                next.voxels = to_voxels(next.metres);
                scatterer.g = meet_medium(line, flight);
                from_surface = false;
            }
            first = false;
            if (!(beta_.max_abs() > 0.0)) break;
            ++count_.scatterings;
            add_sun(next, direction, scatterer);
            add_sky_sample(next, direction, scatterer);
            if constexpr (Emitters) {
                if (!scatterer.surface) add_emitter_sample(next, direction, scatterer);
            }
            if (!roulette(scatterings)) break;
            const Vec3 to = scatterer.sample(direction, random_);
            density = scatterer.value(direction, to);
            if (!(density > 0.0)) break;
            direction = to;
            at = next;
            range = {};
        }
        return result_;
    }

  private:
    Vec3 to_voxels(const Vec3& metres) const {
        return (metres - scene_.corner_m) / scene_.voxel_size_m;
    }

    Hit trace_voxels(const PathPlace& at, const Vec3& direction, const TRange& range) {
        const TraceRange in_voxels{range.begin / scene_.voxel_size_m,
                                   range.end / scene_.voxel_size_m};
        const Hit hit = trace(scene_.tree, {at.voxels, direction}, {}, in_voxels);
        count_.steps += hit.steps;
        return hit;
    }

    void collect_and_pass(MediaLine<N>& line) {
        const auto widen = [](const Spectrum<N>& w) {
            if constexpr (N == 1) {
                return Spectrum<3>(w[0]);
            } else {
                return w;
            }
        };
        const auto collect = [&](double t, const Spectrum<N>& weight_over_b) {
            result_.radiance += to_vec3(beta_ * widen(weight_over_b) * line.emitted_per_m(t));
        };
        beta_ *= widen(
            RatioTracking<true>::transmittance<Traits>(line, random_, count_.flights, collect));
    }

    FlightEnd fly(MediaLine<N>& line) {
        TrackCount& count = count_.flights;
        const auto collect = [&](double t, const Spectrum<3>& weight_over_b) {
            if constexpr (Traits::kEmits) {
                result_.radiance += to_vec3(weight_over_b * line.emitted_per_m(t));
            }
        };
        if constexpr (!Tracker::kScalar) {
            return Tracker::template fly<Traits>(line, beta_, random_, count, collect);
        } else if constexpr (N == 1) {
            Spectrum<1> w(1.0);
            using Gray = TrackTraits<1, false, Traits::kEmits>;
            const FlightEnd end = Tracker::template fly<Gray>(
                line, w, random_, count,
                [&](double t, const Spectrum<1>& weight) { collect(t, beta_ * weight[0]); });
            beta_ *= w[0];
            return end;
        } else {
            // A flight of one channel, drawn by its weight; the others end here.
            Spectrum<3> size;
            for (int c = 0; c < 3; ++c) size[c] = std::abs(beta_[c]);
            const int channel = detail::draw_channel(size, random_);
            const double weight = beta_[channel] * size.sum() / size[channel];
            ChannelLine<MediaLine<N>> one(line, channel);
            Spectrum<1> w(weight);
            const FlightEnd end =
                Tracker::template fly<TrackTraits<1, Traits::kAbsorbs, Traits::kEmits>>(
                    one, w, random_, count, [&](double t, const Spectrum<1>& wb) {
                        Spectrum<3> in_channel;
                        in_channel[channel] = wb[0];
                        collect(t, in_channel);
                    });
            beta_ = Spectrum<3>();
            beta_[channel] = w[0];
            return end;
        }
    }

    /// Chooses the medium that scattered and weighs the path by its albedo; returns its g.
    double meet_medium(const MediaLine<N>& line, const FlightEnd& flight) {
        const std::vector<Medium>& media = scene_.media.all();
        size_t chosen = 0;
        if (media.size() > 1) chosen = choose_medium(line.collided(flight, Tracker::kDecomposes));
        const Medium& medium = media[chosen];
        if constexpr (N == 1 && Traits::kAbsorbs) {
            const Spectrum<3> extinction = medium.unit.extinction();
            for (int c = 0; c < 3; ++c) beta_[c] *= medium.unit.scattering[c] / extinction[c];
        }
        return medium.spec.g;
    }

    size_t choose_medium(const Densities& densities) {
        const std::vector<Medium>& media = scene_.media.all();
        std::array<Spectrum<3>, kMaxMedia> parts;
        Spectrum<3> all;
        for (size_t k = 0; k < media.size(); ++k) {
            parts[k] =
                (N == 1 ? media[k].unit.extinction() : media[k].unit.scattering) * densities[k];
            all += parts[k];
        }
        double sum = 0.0;
        std::array<double, kMaxMedia> weights{};
        for (size_t k = 0; k < media.size(); ++k) {
            weights[k] = (beta_ * parts[k]).mean_abs();
            sum += weights[k];
        }
        double u = random_.uniform() * sum;
        size_t chosen = 0;
        for (size_t k = 0; k < media.size(); ++k) {
            if (!(weights[k] > 0.0)) continue;
            chosen = k;
            if (u < weights[k]) break;
            u -= weights[k];
        }
        if (sum > 0.0) {
            const double probability = weights[chosen] / sum;
            for (int c = 0; c < 3; ++c) {
                if (beta_[c] != 0.0) beta_[c] *= parts[chosen][c] / (all[c] * probability);
            }
        }
        return chosen;
    }

    PathPlace surface_place(const Hit& hit) const {
        PathPlace place;
        place.voxels = hit.point;
        const int axis = axis_of(hit.entry_face);
        place.voxels[axis] = hit.corner[axis] + (index_of(hit.entry_face) % 2 == 0 ? 1 : 0);
        place.metres = place.voxels * scene_.voxel_size_m + scene_.corner_m;
        return place;
    }

    /// Adds what the voxel emits and weighs the path by its albedo. `density`: of the direction.
    Scatterer meet_surface(const Hit& hit, const PathPlace& from, const Vec3& direction,
                           double density) {
        const ColorPyramid& colors = scene_.tree.colors();
        const ColorIndex index = color_index(scene_.tree, hit, 0);
        if (scene_.lighting.emission && !colors.emission.empty()) {
            const Spectrum<3> light = beta_ * to_spectrum(colors.emission[index]);
            if (!(density > 0.0)) {
                result_.radiance += to_vec3(light);
            } else if (light.max_abs() > 0.0) {
                add_emitted(light, hit_weight(hit, from, direction, density), light);
            }
        }
        beta_ *= to_spectrum(colors.albedo[index]);
        Scatterer scatterer{.surface = true};
        const int face = index_of(hit.entry_face);
        scatterer.normal[face / 2] = face % 2 == 0 ? 1.0 : -1.0;
        return scatterer;
    }

    /// Balance heuristic between scattering in a direction and drawing it by its emitter.
    double hit_weight(const Hit& hit, const PathPlace& from, const Vec3& direction,
                      double density) const {
        if constexpr (Emitters) {
            const uint32_t voxel = color_index(scene_.tree, hit, 0).index;
            const double probability =
                scene_.emitters->probability(from.voxels, voxel, hit.entry_face);
            return density / (density + sampled_density(hit, direction, probability));
        } else {
            return 1.0;
        }
    }

    static double sampled_density(const Hit& hit, const Vec3& direction, double probability) {
        if (!(probability > 0.0)) return 0.0;
        const double cosine = std::abs(direction[axis_of(hit.entry_face)]);
        return EmitterSampler::density(probability, hit.t, cosine);
    }

    /// Adds light of an emissive voxel that a scattering met, weighed; `unweighed`: as it would
    /// count if scattering alone found it.
    void add_emitted(const Spectrum<3>& light, double weight, const Spectrum<3>& unweighed) {
        const Spectrum<3> weighed = light * weight;
        result_.radiance += to_vec3(weighed);
        result_.emitted += to_vec3(weighed);
        result_.chance2 += to_vec3(weighed * unweighed);
    }

    /// Towards a point of an emissive voxel. Only what the ray meets there counts, so that it is
    /// what scattering in that direction would have met.
    void add_emitter_sample(const PathPlace& at, const Vec3& from, const Scatterer& scatterer) {
        const double u = random_.uniform();
        const double v = random_.uniform();
        const auto sample = scene_.emitters->sample(at.voxels, {u, v, random_.uniform()});
        if (!sample) return;
        const Vec3 towards = glm::normalize(sample->point - at.voxels);
        const double value = scatterer.value(from, towards);
        if (!(value > 0.0)) return;
        ++count_.shadow_rays;
        const Hit hit = trace_voxels(at, towards, {});
        if (!hit || hit.corner != sample->corner || hit.entry_face != sample->face) return;
        const double density = sampled_density(hit, towards, sample->probability);
        const ColorIndex index = color_index(scene_.tree, hit, 0);
        const Spectrum<3> light = beta_ * to_spectrum(scene_.tree.colors().emission[index]);
        const Spectrum<3> through = transmittance(at, towards, {0.0, hit.t * scene_.voxel_size_m});
        add_emitted(light * through, value / (density + value), light);
    }

    Spectrum<3> transmittance(const PathPlace& from, const Vec3& towards, const TRange& range) {
        const Ray ray{from.metres, towards};
        if (tracer_.choice().transmittance == TransmittanceKind::kClosedForm) {
            return exp(scene_.media.optical_depth(ray, range) * -1.0);
        }
        MediaLine<N> line(scene_.media, ray, range);
        Spectrum<N> t;
        switch (tracer_.choice().transmittance) {
            case TransmittanceKind::kRatio:
                t = RatioTracking<false>::transmittance<Traits>(line, random_, count_.shadows);
                break;
            case TransmittanceKind::kResidualRatio:
                t = ResidualRatio::transmittance<Traits>(line, random_, count_.shadows);
                break;
            case TransmittanceKind::kDelta:
                if constexpr (N == 1) {
                    t = DeltaVisibility::transmittance<Traits>(line, random_, count_.shadows);
                    break;
                }
                [[fallthrough]];
            default:
                t = RatioTracking<true>::transmittance<Traits>(line, random_, count_.shadows);
        }
        count_.shadows.faults += line.unbounded();
        if constexpr (N == 1) {
            return Spectrum<3>(t[0]);
        } else {
            return t;
        }
    }

    /// Adds beta × value × radiance (or irradiance) × what comes through.
    void add_light(const PathPlace& at, const Vec3& towards, double value, const Rgb& light) {
        if (!(value > 0.0)) return;
        ++count_.shadow_rays;
        const ShadowResult shadow =
            cast_shadow_ray(scene_.tree, {at.voxels, towards},
                            std::numeric_limits<double>::infinity(), scene_.shadow);
        count_.steps += shadow.blocker.steps;
        if (!shadow.visible) return;
        const Spectrum<3> through = transmittance(at, towards, {});
        result_.radiance += to_vec3(beta_ * through * to_spectrum(light) * value);
    }

    void add_sun(const PathPlace& at, const Vec3& from, const Scatterer& scatterer) {
        if (!scene_.lighting.sun) return;
        const Sun& sun = *scene_.lighting.sun;
        Vec3 towards = glm::normalize(sun.direction);
        if (sun.angular_diameter_deg > 0.0) {
            const double radius = sun.angular_diameter_deg * std::numbers::pi / 360.0;
            const double u = random_.uniform();
            // 1 − cos by the half angle, which keeps its digits for a disc of half a degree.
            const double s = std::sin(0.5 * radius);
            towards = around(towards, 1.0 - u * 2.0 * s * s, random_.uniform());
        }
        add_light(at, towards, scatterer.value(from, towards), sun.irradiance);
    }

    void add_sky_sample(const PathPlace& at, const Vec3& from, const Scatterer& scatterer) {
        if (tracer_.sky().empty()) return;
        const double u = random_.uniform();
        const SkySampler::Sample sample = tracer_.sky().sample(u, random_.uniform());
        const double value = scatterer.value(from, sample.direction);
        // Balance heuristic: value is the density of scattering there.
        add_light(at, sample.direction, value / (sample.pdf + value),
                  scene_.lighting.sky.radiance(sample.direction));
    }

    void add_sky(const Vec3& direction, double density) {
        const Spectrum<3> sky = to_spectrum(scene_.lighting.sky.radiance(direction));
        double weight = 1.0;
        if (density > 0.0 && !tracer_.sky().empty()) {
            weight = density / (density + tracer_.sky().pdf(direction));
        }
        result_.radiance += to_vec3(beta_ * sky * weight);
    }

    bool roulette(int scatterings) {
        if (scatterings < tracer_.settings().roulette_from) return true;
        const double below = tracer_.settings().roulette_below;
        const double most = beta_.max_abs();
        if (!(most < below)) return true;
        const double survive = most / below;
        if (!(random_.uniform() < survive)) return false;
        beta_ *= 1.0 / survive;
        return true;
    }

    const PathTracer& tracer_;
    const ScatterScene& scene_;
    PathRandom& random_;
    PathCount& count_;
    Spectrum<3> beta_{1.0};  // throughput
    PathResult result_;
};

template <class Tracker, class Traits, bool Emitters>
PathResult trace_path(const PathTracer& tracer, const Ray& ray_m, const TRange& range,
                      PathRandom& random, PathCount& count) {
    return PathLoop<Tracker, Traits, Emitters>(tracer, random, count).run(ray_m, range);
}

template <class Tracker, class Traits>
PathTracer::Instance instance_with(bool emitters) {
    return emitters ? trace_path<Tracker, Traits, true> : trace_path<Tracker, Traits, false>;
}

/// The instance of a tracker for the traits of a choice.
template <class Tracker, int Channels>
PathTracer::Instance instance_of(const TrackerChoice& choice, bool emitters) {
    if (choice.absorbs) {
        return choice.emits ? instance_with<Tracker, TrackTraits<Channels, true, true>>(emitters)
                            : instance_with<Tracker, TrackTraits<Channels, true, false>>(emitters);
    }
    // Nothing emits that does not absorb.
    return instance_with<Tracker, TrackTraits<Channels, false, false>>(emitters);
}

}  // namespace probebake
