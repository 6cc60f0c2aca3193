#include "bake/result_record.h"

#include <bit>
#include <limits>
#include <type_traits>

namespace probebake {
namespace {

/// Of the fields below, in their order. Another order or another field is another version.
constexpr uint64_t kVersion = 9;

class Damaged {};

/// Unsigned integers in groups of seven bits, doubles by their bits.
class Writer {
  public:
    template <class... T>
    void operator()(const T&... values) {
        (put(values), ...);
    }
    std::string take() { return std::move(bytes_); }

  private:
    void number(uint64_t value) {
        for (; value >= 0x80; value >>= 7) bytes_ += static_cast<char>((value & 0x7f) | 0x80);
        bytes_ += static_cast<char>(value);
    }
    void put(const double& value) {
        const auto bits = std::bit_cast<uint64_t>(value);
        for (int i = 0; i < 64; i += 8) bytes_ += static_cast<char>(bits >> i & 0xff);
    }
    void put(const std::string& text) {
        number(text.size());
        bytes_ += text;
    }
    template <class T>
    requires std::is_integral_v<T> || std::is_enum_v<T>
    void put(const T& value) { number(static_cast<uint64_t>(value)); }
    template <class T>
    void put(const std::optional<T>& value) {
        number(value ? 1 : 0);
        if (value) put(*value);
    }
    template <class T, size_t n>
    void put(const std::array<T, n>& values) {
        for (const T& value : values) put(value);
    }
    void put(const float& value) {
        const auto bits = std::bit_cast<uint32_t>(value);
        for (int i = 0; i < 32; i += 8) bytes_ += static_cast<char>(bits >> i & 0xff);
    }
    void put(const Vec3& v) { (*this)(v.x, v.y, v.z); }
    void put(const Image& image) {
        (*this)(image.width(), image.height());
        for (const Rgb& c : image.pixels()) (*this)(c.r, c.g, c.b);
    }
    template <class T>
    void put(const std::vector<T>& values) {
        number(values.size());
        for (const T& value : values) put(value);
    }
    template <class T>
    requires std::is_class_v<T>
    void put(const T& value) { fields(*this, value); }

    std::string bytes_;
};

class Reader {
  public:
    explicit Reader(std::string_view bytes) : bytes_(bytes) {}
    template <class... T>
    void operator()(T&... values) {
        (get(values), ...);
    }
    bool at_end() const { return bytes_.empty(); }

  private:
    uint8_t byte() {
        if (bytes_.empty()) throw Damaged();
        const auto value = static_cast<uint8_t>(bytes_.front());
        bytes_.remove_prefix(1);
        return value;
    }
    uint64_t number() {
        uint64_t value = 0;
        for (int shift = 0; shift < 64; shift += 7) {
            const uint64_t part = byte();
            value |= (part & 0x7f) << shift;
            if (part < 0x80) return value;
        }
        throw Damaged();
    }
    void get(double& value) {
        uint64_t bits = 0;
        for (int i = 0; i < 64; i += 8) bits |= uint64_t{byte()} << i;
        value = std::bit_cast<double>(bits);
    }
    void get(std::string& text) {
        const uint64_t size = number();
        if (size > bytes_.size()) throw Damaged();
        text = bytes_.substr(0, size);
        bytes_.remove_prefix(size);
    }
    template <class T>
    requires std::is_integral_v<T> || std::is_enum_v<T>
    void get(T& value) { value = static_cast<T>(number()); }
    template <class T>
    void get(std::optional<T>& value) {
        if (number() == 0) {
            value.reset();
        } else {
            get(value.emplace());
        }
    }
    template <class T, size_t n>
    void get(std::array<T, n>& values) {
        for (T& value : values) get(value);
    }
    void get(float& value) {
        uint32_t bits = 0;
        for (int i = 0; i < 32; i += 8) bits |= uint32_t{byte()} << i;
        value = std::bit_cast<float>(bits);
    }
    void get(Vec3& v) { (*this)(v.x, v.y, v.z); }
    void get(Image& image) {
        const uint64_t width = number();
        const uint64_t height = number();
        if (width > bytes_.size() || height > bytes_.size()) throw Damaged();
        if (width * height > bytes_.size() / sizeof(Rgb)) throw Damaged();
        image = Image(static_cast<int>(width), static_cast<int>(height));
        for (Rgb& c : image.pixels()) (*this)(c.r, c.g, c.b);
    }
    template <class T>
    void get(std::vector<T>& values) {
        const uint64_t size = number();
        if (size > bytes_.size()) throw Damaged();
        values.resize(size);
        for (T& value : values) get(value);
    }
    template <class T>
    requires std::is_class_v<T>
    void get(T& value) { fields(*this, value); }

    std::string_view bytes_;
};

// One list of fields for both ways, taken apart so that a new one cannot be forgotten. `T` is const
// where it is written.

template <class T, class Of>
concept Either = std::is_same_v<std::remove_const_t<T>, Of>;

template <class Archive, Either<MediaCost> T>
void fields(Archive& archive, T& cost) {
    auto& [lookups, leaves, collisions, null_collisions, scatterings, shadow_rays, faults] = cost;
    archive(lookups, leaves, collisions, null_collisions, scatterings, shadow_rays, faults);
}

template <class Archive, Either<CostStats> T>
void fields(Archive& archive, T& cost) {
    auto& [rays, discarded_rays, missed_rays, steps, box_tests, level_histogram, seconds, media] =
        cost;
    archive(rays, discarded_rays, missed_rays, steps, box_tests, level_histogram, seconds, media);
}

template <class Archive, Either<HybridSwitches> T>
void fields(Archive& archive, T& hybrid) {
    auto& [start_lists, nested_rays] = hybrid;
    archive(start_lists, nested_rays);
}

template <class Archive, Either<RenderSettings> T>
void fields(Archive& archive, T& s) {
    auto& [kind, threshold, decay, leaf_grid, shifted_grid, spread, price, least_grid, hybrid,
           samples, noise, fixed_level, normaliser, misses_in_kernel] = s;
    archive(kind, threshold, decay, leaf_grid, shifted_grid, spread, price, least_grid, hybrid,
            samples, noise, fixed_level, normaliser, misses_in_kernel);
}

template <class Archive, Either<Estimate> T>
void fields(Archive& archive, T& e) {
    auto& [value, variance, third_moment, samples, degrees_of_freedom, largest, told] = e;
    archive(value, variance, third_moment, samples, degrees_of_freedom, largest, told);
}

template <class Archive, Either<NormEstimate> T>
void fields(Archive& archive, T& e) {
    auto& [squared, variance, variance2, largest, samples, degrees_of_freedom, longest, told] = e;
    archive(squared, variance, variance2, largest, samples, degrees_of_freedom, longest, told);
}

template <class Archive, Either<ShAudit> T>
void fields(Archive& archive, T& audit) {
    auto& [draws, difference, standard_error, irradiance, channels] = audit;
    archive(draws, difference, standard_error, irradiance, channels);
}

template <class Archive, Either<MeasuredError> T>
void fields(Archive& archive, T& error) {
    auto& [mse, ssim, irradiance, rel_mse, irradiance_square] = error;
    archive(mse, ssim, irradiance, rel_mse, irradiance_square);
}

template <class Archive, Either<IrradianceNoise> T>
void fields(Archive& archive, T& noise) {
    auto& [square, spread, channels] = noise;
    archive(square, spread, channels);
}

template <class Archive, Either<Audit> T>
void fields(Archive& archive, T& audit) {
    auto& [error, pixels, windows, by_lot, predicted, chance, sh, noise, ssim_lost, cost] = audit;
    archive(error, pixels, windows, by_lot, predicted, chance, sh, noise, ssim_lost, cost);
}

template <class Archive, Either<Interval> T>
void fields(Archive& archive, T& interval) {
    auto& [low, high] = interval;
    archive(low, high);
}

template <class Archive, Either<PooledError> T>
void fields(Archive& archive, T& pooled) {
    auto& [value, interval, upper, spread] = pooled;
    archive(value, interval, upper, spread);
}

template <class Archive, Either<AuditedRatio> T>
void fields(Archive& archive, T& ratio) {
    auto& [predicted, measured, variance, draws, chance] = ratio;
    archive(predicted, measured, variance, draws, chance);
}

template <class Archive, Either<ProductFile> T>
void fields(Archive& archive, T& file) {
    auto& [name, bytes, size_bytes, sha256] = file;
    archive(name, size_bytes, sha256);
}

template <class Archive, Either<DdgiTile> T>
void fields(Archive& archive, T& tile) {
    auto& [irradiance, distance] = tile;
    archive(irradiance, distance);
}

template <class Archive, Either<ProbeResult> T>
void fields(Archive& archive, T& result) {
    auto& [probe, state, settings, faces, pixels, limited, looks, earlier_renders, certificate,
           confidence, target_met, evidence, met_by, pooled, first_look, decision_cost, is_float,
           inside_voxel, far_m, wall_seconds, files, ddgi] = result;
    archive(settings, faces, pixels, limited, looks, earlier_renders, certificate, confidence,
            target_met, evidence, met_by, pooled, first_look, decision_cost, is_float, inside_voxel,
            far_m, wall_seconds, files, ddgi);
}

}  // namespace

std::string write_result_record(const ProbeResult& result) {
    Writer writer;
    writer(kVersion, result);
    return writer.take();
}

std::optional<ProbeResult> read_result_record(std::string_view record, const JobSpec& job,
                                              size_t unit) {
    ProbeResult result;
    try {
        Reader reader(record);
        uint64_t version = 0;
        reader(version);
        if (version != kVersion) return std::nullopt;
        reader(result);
        if (!reader.at_end()) return std::nullopt;
    } catch (const Damaged&) {
        return std::nullopt;
    }
    result.probe = unit / job.states.size();
    result.state = job.states[unit % job.states.size()];
    return result;
}

}  // namespace probebake
