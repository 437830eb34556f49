#include "common/scoring/critical.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/scoring/reasons.h"
#include "common/scoring/uncertainty.h"

namespace enamel::scoring {
namespace {

constexpr CriticalError kErrors[] = {
    {"pulp_exposed", "The pulp is exposed"},
    {"nothing_cut", "Nothing of the task was cut"},
    {"all_cut", "The crown of the tooth was cut away"},
    {"neighbour_damaged", "The adjacent tooth is damaged"},
    {"wrong_place", "The cavity is in the wrong place"},
    {"occlusal_untouched", "The occlusal surface is not reduced"},
    {"one_axial_wall_untouched", "One side of the tooth is not reduced"},
    {"finish_line_missing", "Part of the finish line is missing"},
    {"cannot_seat", "The crown cannot seat: opposite walls are undercut"},
    {"contact_left", "The contact with the adjacent tooth is not broken"},
    {"caries_left_deep", "Much of the caries was left"},
    {"gross_overextension", "The cavity is grossly over-extended"},
};

// "0.31 mm, at most 0.25 mm"; of a borderline value with its uncertainty.
std::string Limit(const CriticalResult& c) {
  const std::string unit = c.unit;
  const Reason reason{c.above ? "at_most" : "at_least", {c.value, c.limit}, {}};
  auto number = [&](size_t i) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", ReasonDigits(reason, i, unit), reason.values[i]);
    return WithUnit(text, unit);
  };
  return number(0) + ", " + (c.above ? "at most " : "at least ") + number(1);
}

}  // namespace

std::span<const CriticalError> CriticalErrors() { return kErrors; }

const CriticalError* FindCriticalError(std::string_view code) {
  const auto* it = std::ranges::find(kErrors, code, &CriticalError::code);
  return it == std::end(kErrors) ? nullptr : it;
}

bool IsBorderline(double value, double limit, double uncertainty) {
  const double off = std::fabs(value - limit);
  return (off > 0 || value != 0) && uncertainty > 0 && off <= kBorderlineWithin * uncertainty;
}

Result<FoundCritical> FindCritical(const scene::Rubric& rubric, const MetricSet& metrics) {
  FoundCritical out;
  for (const scene::RubricCritical& asked : rubric.critical) {
    const auto value = std::ranges::find(metrics.values, asked.metric, &MetricValue::name);
    if (value == metrics.values.end()) {
      const auto none = std::ranges::find(metrics.missing, asked.metric, &MissingMetric::name);
      if (none != metrics.missing.end() && none->why != NoValue::kNotUsed) continue;
    }
    if (value == metrics.values.end() || !std::isfinite(value->value)) {
      return Status(Code::kInvalidInput,
                    "the rubric's critical error " + asked.error + " needs metric " + asked.metric +
                        ", which was not measured; score the recording again",
                    asked.metric);
    }
    const double uncertainty = value->uncertainty.value_or(0);
    const bool borderline = IsBorderline(value->value, asked.limit, uncertainty);
    const bool passes = asked.above ? value->value <= asked.limit : value->value >= asked.limit;
    if (passes && !borderline) continue;
    auto& list = borderline ? out.borderline : out.critical;
    CriticalResult& c =
        list.emplace_back(CriticalResult{asked.error, asked.metric, value->value, asked.unit,
                                         asked.limit, asked.above, uncertainty, ""});
    c.reason = std::string(FindCriticalError(asked.error)->said) + " (" + Limit(c) + ").";
  }
  return out;
}

Status CheckCriticalIsMeasured(const scene::Rubric& rubric, const MetricSet& metrics) {
  for (size_t i = 0; i < rubric.critical.size(); ++i) {
    const scene::RubricCritical& c = rubric.critical[i];
    const bool never = std::ranges::any_of(metrics.missing, [&](const MissingMetric& m) {
      return m.name == c.metric && m.why == NoValue::kNotInTask;
    });
    if (!never) continue;
    const std::string field = "critical[" + std::to_string(i) + "].metric";
    return Status(Code::kInvalidInput,
                  "rubric, " + field + ": expected a metric that the exercise measures, found " +
                      c.metric + ": " + c.error + " could never be found; leave it out",
                  field);
  }
  return Status::Ok();
}

}  // namespace enamel::scoring
