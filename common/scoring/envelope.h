#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/scoring/metrics.h"

// Several dentists' cuts of one exercise, and where an attempt lies among them (schemas/score.md,
// "Envelope"). It judges nothing: points come from the rubric and one reference.
// Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

inline constexpr size_t kMaxEnvelopeMembers = 8;

// One dentist's cut. Nothing is owned but the metrics.
struct EnvelopeMember {
  std::string attempt;  // UUID text
  const cutting::Volume* final_volume = nullptr;
  MetricSet metrics;  // against the reference that the attempt is compared with
};

// Where a value lies among the members'.
struct MetricPlace {
  std::string name;
  std::string unit;
  double least = 0, median = 0, most = 0;  // of the members
  // 1.4826 times the median distance from the median: the standard deviation, where the members'
  // values are normally distributed, and not moved by one that is not.
  double spread = 0;
  // (value - median) / spread; none where the members agree (spread 0).
  std::optional<double> z;
  double percentile = 0;  // share of members below the value, half of those equal, in percent

  bool operator==(const MetricPlace&) const = default;
};

struct EnvelopeOverlap {
  std::string attempt;
  double dice = 0;  // of what the two took away; 1 for two that took nothing

  bool operator==(const EnvelopeOverlap&) const = default;
};

struct Envelope {
  std::vector<EnvelopeOverlap> members;  // nearest first
  double left_of_all_m3 = 0;             // taken by every member and left by the attempt
  double disputed_m3 = 0;                // taken by some members and not by all
  // What the attempt took and exactly k members took too, k = 0 … members.
  std::vector<double> taken_by_m3;
  std::vector<MetricPlace> metrics;  // those with a value in the attempt and in every member

  bool operator==(const Envelope&) const = default;
};

// Requires: 2 to kMaxEnvelopeMembers members, equal grids. Errors: kInvalidInput otherwise.
Result<Envelope> PlaceInEnvelope(const cutting::Volume& initial, const cutting::Volume& attempt,
                                 const MetricSet& metrics,
                                 const std::vector<EnvelopeMember>& members);

}  // namespace enamel::scoring
