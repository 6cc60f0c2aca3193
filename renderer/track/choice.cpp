#include "track/choice.h"

#include <array>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace probebake {
namespace {

constexpr std::array<const char*, kTrackerKinds> kNames = {
    "none",
    "closed_form",
    "transmittance",
    "delta",
    "weighted_delta",
    "analog_decomposition",
    "weighted_decomposition",
    "spectral_max",
    "spectral_average",
    "history_max",
    "history_average",
    "spectral_max_decomposition",
    "history_average_decomposition",
    "spectral_mis",
};

std::string short_number(double x) {
    std::ostringstream text;
    text.precision(3);
    text << x;
    return text.str();
}

struct Rule {
    TrackerKind tracker;
    std::string reason;
};

Rule rule_for(const MediaFacts& facts, const ChoiceParams& params) {
    if (!facts.absorbs && !facts.scatters) return {TrackerKind::kNone, "there are no media"};
    // A homogeneous medium's emission is that of flights in closed form.
    if (!facts.scatters && !(facts.homogeneous && facts.emits)) {
        return {TrackerKind::kTransmittance, std::string("nothing scatters: transmittance") +
                                                 (facts.emits ? " and emission along it" : "") +
                                                 " alone"};
    }
    if (facts.homogeneous) {
        return {TrackerKind::kClosedForm, "all media are homogeneous: distances in closed form"};
    }
    const bool decompose =
        facts.residual_share < params.most_residual && params.lookup_cost > params.costly_lookup;
    if (facts.gray_extinction) {
        const std::string gray = "extinction is the same in all channels: one scalar flight";
        if (decompose) {
            return {TrackerKind::kAnalogDecomposition,
                    gray + "; the residual is " + short_number(facts.residual_share) +
                        " of the majorant and look-ups are costly"};
        }
        return {TrackerKind::kDelta, gray};
    }
    const std::string ratio =
        "extinction differs between channels by up to " + short_number(facts.extinction_ratio);
    if (!(facts.extinction_ratio <= params.most_ratio)) {
        return {TrackerKind::kSpectralMis, ratio + ": above " + short_number(params.most_ratio) +
                                               " one majorant for all loses the thin channels"};
    }
    return {decompose ? TrackerKind::kHistoryAverageDecomposition : TrackerKind::kHistoryAverage,
            ratio + ": weights stay bounded"};
}

}  // namespace

const char* name_of(TrackerKind kind) { return kNames[static_cast<size_t>(kind)]; }

const char* name_of(TransmittanceKind kind) {
    switch (kind) {
        case TransmittanceKind::kClosedForm:
            return "closed_form";
        case TransmittanceKind::kDelta:
            return "delta";
        case TransmittanceKind::kRatio:
            return "ratio";
        case TransmittanceKind::kRatioRoulette:
            return "ratio_roulette";
        case TransmittanceKind::kResidualRatio:
            break;
    }
    return "residual_ratio";
}

std::optional<TrackerKind> tracker_named(const std::string& name) {
    for (size_t i = 0; i < kNames.size(); ++i) {
        if (name == kNames[i]) return static_cast<TrackerKind>(i);
    }
    return std::nullopt;
}

MediaFacts facts_of(const Media& media) {
    MediaFacts facts;
    double residual = 0.0;
    double majorant = 0.0;
    for (const Medium& medium : media.all()) {
        const Spectrum<3> extinction = medium.unit.extinction();
        facts.absorbs = facts.absorbs || medium.unit.absorption.max() > 0.0;
        facts.scatters = facts.scatters || medium.unit.scattering.max() > 0.0;
        facts.emits = facts.emits || (medium.unit.absorption * medium.source).max() > 0.0;
        if (extinction.max() > extinction.min() * (1.0 + 1e-6)) facts.gray_extinction = false;
        facts.extinction_ratio =
            std::max(facts.extinction_ratio, extinction.min() > 0.0
                                                 ? extinction.max() / extinction.min()
                                                 : std::numeric_limits<double>::infinity());
        if (!std::holds_alternative<HomogeneousShape>(medium.spec.shape)) facts.homogeneous = false;
        if (medium.is_grid()) {
            facts.has_grid = true;
            // Weighed by how thick the medium may be.
            const double weight = extinction.max() * double{medium.octree.nodes().front().most};
            residual += weight * medium.octree.residual_share();
            majorant += weight;
        }
    }
    if (majorant > 0.0) facts.residual_share = residual / majorant;
    return facts;
}

TrackerChoice choose_tracker(const MediaFacts& facts, const ChoiceParams& params) {
    Rule rule = rule_for(facts, params);
    if (params.forced && *params.forced != rule.tracker) {
        const TrackerKind forced = *params.forced;
        if (rule.tracker == TrackerKind::kNone || forced == TrackerKind::kNone) {
            throw std::invalid_argument(std::string("tracker '") + name_of(forced) +
                                        "': expected '" + name_of(rule.tracker) + "', because " +
                                        rule.reason);
        }
        if (forced == TrackerKind::kClosedForm && !facts.homogeneous) {
            throw std::invalid_argument(
                "tracker 'closed_form': a density varies; expected one of the others");
        }
        if (forced == TrackerKind::kTransmittance && facts.scatters) {
            throw std::invalid_argument(
                "tracker 'transmittance': a medium scatters; expected one of the others");
        }
        rule = {forced, std::string("the client chose it; by itself it would be ") +
                            name_of(rule.tracker) + ", because " + rule.reason};
    }
    TrackerChoice choice;
    choice.tracker = rule.tracker;
    choice.reason = rule.reason;
    choice.gray = facts.gray_extinction && rule.tracker >= TrackerKind::kTransmittance &&
                  rule.tracker <= TrackerKind::kWeightedDecomposition;
    choice.absorbs = facts.absorbs;
    choice.emits = facts.emits;
    choice.transmittance =
        facts.has_grid ? TransmittanceKind::kRatioRoulette : TransmittanceKind::kClosedForm;
    const auto leave_out = [&](bool when, const char* text) {
        if (when) choice.left_out.emplace_back(text);
    };
    if (rule.tracker == TrackerKind::kNone) {
        leave_out(true, "media: there are none");
        return choice;
    }
    leave_out(!facts.scatters, "scattering: nothing scatters");
    leave_out(!facts.absorbs, "absorption: the albedo is 1");
    leave_out(!facts.emits, "emission: no medium emits");
    leave_out(choice.gray, "spectral weights: extinction is gray");
    leave_out(!facts.has_grid, "sampled transmittance: columns are known in closed form");
    return choice;
}

}  // namespace probebake
