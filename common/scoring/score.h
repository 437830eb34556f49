#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "common/scoring/metrics.h"

namespace enamel::scoring {

struct CriterionResult {
  std::string name;       // metric
  std::string title;
  double value = 0;
  std::string unit;
  double points = 0;
  double max_points = 0;
  std::string reason;     // one sentence for the student: what was found, what was asked for
};

// A score is metrics + rubric version + reference + core version; recomputed bit-identically.
struct ScoreResult {
  double score = 0;                          // 0..100
  bool critical_fail = false;
  std::vector<CriterionResult> criteria;
  std::vector<MetricValue> metrics;          // all of them, also those the rubric does not use
  std::string reference_attempt;             // UUID text
  int32_t rubric_version = 1;
  uint32_t core_version = core::kCoreVersion;
  // From the replay: the station's part in the attempt.
  uint64_t ticks = 0, gap_ticks = 0, late_ticks = 0, bounded_ticks = 0;
  bool witness_ok = false;
  std::string witness_note;                  // where it broke, when it did
  double replay_realtime_factor = 0;         // not part of the comparison of two scores
};

// Errors: kInvalidInput when the rubric names an unknown metric, another unit, an unsorted map.
Status ValidateRubric(const scene::Rubric& rubric);
Result<ScoreResult> ApplyRubric(const scene::Rubric& rubric, const std::vector<MetricValue>& metrics);

std::string ToJson(const ScoreResult& result);
Result<ScoreResult> ScoreFromJson(std::string_view json);

}  // namespace enamel::scoring
