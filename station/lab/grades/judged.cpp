#include "station/lab/grades/judged.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "common/scoring/reasons.h"
#include "common/scoring/remedies.h"
#include "common/scoring/tolerances.h"

namespace enamel::station::lab {
namespace {

// Which criteria are about a mistake. Where a rubric has none of the first list, the second.
struct Cause {
  std::string_view name;
  std::vector<std::string_view> faults;  // beginnings of their names
  std::vector<std::string_view> metrics, instead;
};
const std::vector<Cause>& Causes() {
  static const std::vector<Cause> causes = {
      {"wave",
       {"waviness", "floor_waviness", "finish_waviness"},
       {"wall_waviness_mm", "floor_waviness_mm", "finish_waviness_mm"},
       {"deviation_rms_mm"}},
      {"wall",
       {"wall_", "walls_"},
       {"wall_mesial_mm", "wall_distal_mm", "wall_buccal_mm", "wall_lingual_mm"},
       {"deviation_rms_mm", "sound_removed_mm3", "caries_left_percent"}},
      {"tilt",
       {"tilt_floor"},
       {"tilt_floor_deg"},
       {"deviation_rms_mm", "sound_removed_mm3", "caries_left_percent"}},
      {"tilt", {"tilt_"}, {"wall_tilt_deg"}, {"deviation_rms_mm", "sound_removed_mm3"}},
      {"tilt",
       {"undercut"},
       {"undercut_deg", "crown_undercut_mm2", "convergence_mesiodistal_deg"},
       {"wall_tilt_deg", "deviation_rms_mm"}},
      // A stump that is slimmer all around, so that it can lean: nothing else is about that.
      {"tilt",
       {"lean"},
       {"crown_axis_deg", "crown_undercut_mm2", "deviation_rms_mm"},
       {"deviation_rms_mm"}},
      {"floor",
       {"floor", "top_"},
       {"floor_mm", "reduction_top_percent"},
       {"deviation_rms_mm", "sound_removed_mm3", "caries_left_percent"}},
      {"shift",
       {"shift_"},
       {"wall_mesial_mm", "wall_distal_mm", "wall_buccal_mm", "wall_lingual_mm"},
       {"deviation_rms_mm", "sound_removed_mm3", "caries_left_percent"}},
      {"turn",
       {"turn"},
       {"wall_mesial_mm", "wall_distal_mm", "wall_buccal_mm", "wall_lingual_mm"},
       {"deviation_rms_mm", "sound_removed_mm3", "caries_left_percent"}},
      {"taper",
       {"taper", "convergence"},
       {"wall_tilt_deg", "convergence_mesiodistal_deg"},
       {"deviation_rms_mm", "sound_removed_mm3"}},
      {"gouge", {"gouge"}, {"deepest_over_mm"}, {}},
  };
  return causes;
}

const Cause* CauseOf(const std::string& fault) {
  for (const Cause& cause : Causes()) {
    for (std::string_view begins : cause.faults) {
      if (fault.starts_with(begins)) return &cause;
    }
  }
  return nullptr;
}

bool Has(const std::vector<std::string_view>& list, const std::string& name) {
  return std::ranges::find(list, name) != list.end();
}

double ValueOf(const scoring::ScoreResult& score, std::string_view metric) {
  const auto m = std::ranges::find(score.metrics, metric, &scoring::MetricValue::name);
  return m == score.metrics.end() ? 0 : m->value;
}

// The dearest place, criterion or gate.
struct Loss {
  std::string metric;
  double points = 0;  // of a hundred
  double value = 0;
  const std::vector<scene::RubricPoint>* map = nullptr;
  bool gate = false;
  std::string said_of;  // the metric whose fault it is
};

std::vector<Loss> LossesOf(const scene::Rubric& rubric, const scoring::ScoreResult& score) {
  double all = 0, open = 1;
  for (const auto& c : score.criteria) all += c.max_points;
  for (const auto& g : score.gates) open *= g.share;
  std::vector<Loss> out;
  double before = 0;
  for (size_t i = 0; i < score.criteria.size(); ++i) {
    const auto& c = score.criteria[i];
    const double earned = open > 0 ? c.points / open : c.max_points;
    before += 100 * earned / all;
    out.push_back({c.name, 100 * (c.max_points - earned) / all, c.charged, &rubric.criteria[i].map,
                   false, c.name});
  }
  for (size_t i = 0; i < score.gates.size(); ++i) {
    const auto& g = score.gates[i];
    out.push_back({g.name, before * (1 - g.share), g.value, &rubric.gates[i].map, true, g.name});
    if (const auto behind = scoring::CriterionBehind(rubric, score, i)) {
      const auto& c = score.criteria[*behind];
      out.back().said_of = c.name;
      out.back().value = c.charged;
      out.back().map = &rubric.criteria[*behind].map;
    }
  }
  std::ranges::stable_sort(out, std::greater(), &Loss::points);
  return out;
}

void Say(const Loss& most, const scoring::ScoreResult& score, Judged& out) {
  const scoring::Remedy* remedy =
      scoring::RemedyOf(*scoring::FindMetric(most.said_of), most.value, *most.map);
  if (remedy == nullptr) return;
  out.said_fault = remedy->fault;
  out.said_remedy = remedy->code;
  if (remedy->code == scoring::kWhereMost) {
    const bool over = ValueOf(score, "deepest_over_mm") > ValueOf(score, "most_left_mm");
    out.said_remedy = over ? scoring::kStopEarlier : scoring::kCutFurther;
  }
}

}  // namespace

Judged JudgedOf(const Fault& fault, const scene::Rubric& given, const scoring::ScoreResult& score) {
  const scene::Rubric rubric = scoring::WithTolerances(given);
  Judged out;
  const std::vector<Loss> losses = LossesOf(rubric, score);
  for (const Loss& l : losses) {
    if (l.points < 0.05) break;
    char text[96];
    std::snprintf(text, sizeof text, "%s%s %.1f", l.gate ? "gate " : "", l.metric.c_str(),
                  l.points);
    out.lost_for.emplace_back(text);
  }
  const Cause* cause = fault.critical.empty() ? CauseOf(fault.name) : nullptr;
  if (cause != nullptr) out.cause = cause->name;
  if (!score.critical.empty()) {
    out.said_fault = score.critical.front().error;
    const scoring::CriticalResult& c = score.critical.front();
    if (const auto* remedy = scoring::FindRemedy(c.name, c.above)) out.said_remedy = remedy->code;
    return out;
  }
  if (losses.front().points >= scoring::kWorthAdvice) Say(losses.front(), score, out);
  const double lost = 100 - score.score;
  if (cause == nullptr || lost < 1) return out;
  auto judged = [&](std::string_view metric) {
    return std::ranges::any_of(score.criteria, [&](const auto& c) {
      return c.name == metric && c.judged && c.max_points > 0;
    });
  };
  const auto& own = std::ranges::any_of(cause->metrics, judged) ? cause->metrics : cause->instead;
  double charged = 0;
  for (const Loss& l : losses) {
    if (l.gate || Has(own, l.metric)) charged += l.points;
  }
  out.own_share = std::min(1.0, charged / lost);
  return out;
}

}  // namespace enamel::station::lab
