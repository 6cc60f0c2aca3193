#include "bake/result_record.h"

#include <bit>
#include <limits>
#include <type_traits>

namespace probebake {
namespace {

/// Of the fields below, in their order. Another order or another field is another version.
constexpr uint64_t kVersion = 1;

class Damaged {};

/// Unsigned integers in groups of seven bits, doubles by their bits.
class Writer {
  public:
    template <class... T>
    void operator()(T&... values) {
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
    void put(const Vec3& v) { (*this)(v.x, v.y, v.z); }
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
    void get(Vec3& v) { (*this)(v.x, v.y, v.z); }
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

// One list of fields for both ways. `T` is const where it is written.

template <class T, class Of>
concept Either = std::is_same_v<std::remove_const_t<T>, Of>;

template <class Archive, Either<CostStats> T>
void fields(Archive& archive, T& cost) {
    archive(cost.rays, cost.discarded_rays, cost.missed_rays, cost.steps, cost.box_tests,
            cost.level_histogram, cost.seconds);
}

template <class Archive, Either<HybridSwitches> T>
void fields(Archive& archive, T& hybrid) {
    archive(hybrid.start_lists, hybrid.nested_rays);
}

template <class Archive, Either<RenderSettings> T>
void fields(Archive& archive, T& s) {
    archive(s.kind, s.threshold, s.decay, s.leaf_grid, s.spread, s.price, s.hybrid, s.fixed_level,
            s.normaliser, s.misses_in_kernel);
}

template <class Archive, Either<Estimate> T>
void fields(Archive& archive, T& e) {
    archive(e.value, e.variance, e.third_moment, e.samples, e.degrees_of_freedom);
}

template <class Archive, Either<NormEstimate> T>
void fields(Archive& archive, T& e) {
    archive(e.squared, e.variance, e.variance2, e.largest, e.samples, e.degrees_of_freedom);
}

template <class Archive, Either<ShAudit> T>
void fields(Archive& archive, T& audit) {
    archive(audit.draws, audit.difference, audit.standard_error, audit.irradiance, audit.channels);
}

template <class Archive, Either<MeasuredError> T>
void fields(Archive& archive, T& error) {
    archive(error.mse, error.ssim, error.irradiance);
}

template <class Archive, Either<Audit> T>
void fields(Archive& archive, T& audit) {
    archive(audit.error, audit.pixels, audit.windows, audit.sh, audit.cost);
}

template <class Archive, Either<ProductFile> T>
void fields(Archive& archive, T& file) {
    archive(file.name, file.size_bytes, file.sha256);
}

template <class Archive, Either<ProbeResult> T>
void fields(Archive& archive, T& result) {
    archive(result.settings, result.faces, result.pixels, result.limited, result.looks,
            result.earlier_renders, result.certificate, result.decision_cost, result.is_float,
            result.inside_voxel, result.far_m, result.wall_seconds, result.files);
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
