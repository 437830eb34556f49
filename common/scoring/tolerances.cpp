#include "common/scoring/tolerances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <string_view>

#include "common/scene/restoration.h"

namespace enamel::scoring {
namespace {

using scene::DivergenceRange;
using scene::RestorationTolerance;
using scene::Rubric;
using scene::RubricPoint;

constexpr std::string_view kUndercut = "undercut_deg", kTilt = "wall_tilt_deg";

// How walls should lean and meet the tooth's surface is what a material decides: amalgam is held by
// walls that converge, composite is bonded, ceramic has to slide in.
constexpr std::string_view kByMaterial[] = {
    kUndercut,
    kTilt,
    "tilt_mesial_deg",
    "tilt_distal_deg",
    "tilt_buccal_deg",
    "tilt_lingual_deg",
    "divergence_mesial_deg",
    "divergence_distal_deg",
    "divergence_buccal_deg",
    "divergence_lingual_deg",
    "cavosurface_deg",
    "cavosurface_off_deg",
};

struct WallMetrics {
  std::string_view divergence, tilt;
  DivergenceRange RestorationTolerance::Ranges::*range;
};
constexpr WallMetrics kWalls[] = {
    {"divergence_mesial_deg", "tilt_mesial_deg", &RestorationTolerance::Ranges::mesiodistal},
    {"divergence_distal_deg", "tilt_distal_deg", &RestorationTolerance::Ranges::mesiodistal},
    {"divergence_buccal_deg", "tilt_buccal_deg", &RestorationTolerance::Ranges::buccolingual},
    {"divergence_lingual_deg", "tilt_lingual_deg", &RestorationTolerance::Ranges::buccolingual},
};

Status Bad(const std::string& field, const std::string& message) {
  return Status(Code::kInvalidInput, "rubric, " + field + ": " + message, field);
}

bool DependsOnMaterial(std::string_view metric) {
  return std::ranges::find(kByMaterial, metric) != std::end(kByMaterial);
}

const RestorationTolerance* ToleranceOf(const Rubric& rubric) {
  if (rubric.restoration == scene::Restoration::kNone) return nullptr;
  const auto it = std::ranges::find(rubric.restorations, rubric.restoration,
                                    &RestorationTolerance::restoration);
  return it == rubric.restorations.end() ? nullptr : &*it;
}

Status ValidateOne(const Rubric& rubric, const RestorationTolerance& t, const std::string& place) {
  std::set<std::string> seen;
  for (size_t i = 0; i < t.criteria.size(); ++i) {
    const std::string field = place + ".criteria[" + std::to_string(i) + "].metric";
    const std::string& metric = t.criteria[i].metric;
    if (std::ranges::find(rubric.criteria, metric, &scene::RubricCriterion::metric) ==
        rubric.criteria.end()) {
      return Bad(field, "no criterion of this rubric is about \"" + metric + "\"; leave it out");
    }
    if (!seen.insert(metric).second) {
      return Bad(field, "\"" + metric + "\" has tolerances already; leave one of them out");
    }
  }
  for (size_t i = 0; i < t.critical.size(); ++i) {
    const auto& limit = t.critical[i];
    const bool known = std::ranges::any_of(rubric.critical, [&](const auto& c) {
      return c.error == limit.error && c.metric == limit.metric;
    });
    const std::string field = place + ".critical[" + std::to_string(i) + "].error";
    if (!known) {
      return Bad(field, "this rubric has no critical error \"" + limit.error + "\" by " +
                            limit.metric + "; leave it out");
    }
    if (!std::isfinite(limit.limit)) return Bad(field, "expected a finite limit");
  }
  if (!t.divergence) return Status::Ok();
  for (const DivergenceRange& r : {t.divergence->mesiodistal, t.divergence->buccolingual}) {
    if (r.from_deg < r.to_deg) continue;
    return Bad(place + ".divergence_deg", "expected the lesser angle first");
  }
  return Status::Ok();
}

// What both of a lean's ends are taken from.
struct Leaning {
  double divergence_deg, tilt_deg;
  DivergenceRange range;
};

Result<std::vector<Leaning>> Leanings(const RestorationTolerance::Ranges& ranges,
                                      const MetricSet& metrics) {
  std::vector<Leaning> out;
  for (const WallMetrics& wall : kWalls) {
    const auto lean = std::ranges::find(metrics.values, wall.divergence, &MetricValue::name);
    const auto tilt = std::ranges::find(metrics.values, wall.tilt, &MetricValue::name);
    if (lean != metrics.values.end() && tilt != metrics.values.end()) {
      out.push_back({lean->value, tilt->value, ranges.*wall.range});
      continue;
    }
    const auto none = std::ranges::find(metrics.missing, wall.divergence, &MissingMetric::name);
    if (none != metrics.missing.end() && none->why != NoValue::kNotUsed) continue;
    return Status(Code::kInvalidInput,
                  "the rubric's restorative material needs metric " + std::string(wall.divergence) +
                      ", which was not measured; score the recording again",
                  std::string(wall.divergence));
  }
  return out;
}

std::vector<RubricPoint> Moved(std::vector<RubricPoint> map, double by_deg) {
  for (RubricPoint& p : map) p.value += by_deg;
  return map;
}

// Full marks within the range; beyond either end the map's shares.
std::vector<RubricPoint> BothWays(const std::vector<RubricPoint>& map,
                                  const DivergenceRange& range) {
  std::vector<RubricPoint> out;
  for (size_t i = map.size(); i-- > 0;)
    out.push_back({range.from_deg - map[i].value, map[i].share});
  for (const RubricPoint& p : map) out.push_back({range.to_deg + p.value, p.share});
  return out;
}

// The first of those with most.
template <typename F>
const Leaning* Worst(const std::vector<Leaning>& walls, F&& beyond) {
  const Leaning* worst = nullptr;
  for (const Leaning& wall : walls) {
    if (worst == nullptr || beyond(wall) > beyond(*worst)) worst = &wall;
  }
  return worst;
}

JudgedLean UndercutOf(const std::vector<Leaning>& walls, const std::vector<RubricPoint>& map) {
  auto allowed = [](const Leaning& w) { return std::max(0.0, -w.range.from_deg); };
  auto beyond = [&](const Leaning& w) { return -w.divergence_deg - allowed(w); };
  const Leaning& worst = *Worst(walls, beyond);
  return {std::max(0.0, beyond(worst)), std::max(0.0, -worst.divergence_deg),
          Moved(map, allowed(worst))};
}

// What leans over the cavity is undercut_deg's. A wall as the reference's is right.
JudgedLean TiltOf(const std::vector<Leaning>& walls, const std::vector<RubricPoint>& map) {
  auto short_of = [](const Leaning& w) {
    return w.range.from_deg > 0 ? w.range.from_deg - std::max(0.0, w.divergence_deg) : -90;
  };
  auto beyond = [&](const Leaning& w) {
    const double most = std::max(w.divergence_deg - w.range.to_deg, short_of(w));
    return std::min(most, std::fabs(w.tilt_deg));
  };
  const Leaning& worst = *Worst(walls, beyond);
  JudgedLean out{std::max(0.0, beyond(worst)), worst.divergence_deg, {}};
  out.map = worst.range.from_deg > 0 ? BothWays(map, worst.range) : Moved(map, worst.range.to_deg);
  return out;
}

}  // namespace

Status ValidateRestorations(const Rubric& rubric) {
  std::set<scene::Restoration> seen;
  for (size_t i = 0; i < rubric.restorations.size(); ++i) {
    const RestorationTolerance& t = rubric.restorations[i];
    const std::string place = "restorations[" + std::to_string(i) + "]";
    if (scene::RestorationName(t.restoration).empty()) {
      return Bad(place + ".restoration", "expected a material");
    }
    if (!seen.insert(t.restoration).second) {
      return Bad(place + ".restoration", std::string(scene::RestorationName(t.restoration)) +
                                             " has tolerances already; leave one of them out");
    }
    ENAMEL_RETURN_IF_ERROR(ValidateOne(rubric, t, place));
  }
  if (rubric.restoration == scene::Restoration::kNone) return Status::Ok();
  const std::string name(scene::RestorationName(rubric.restoration));
  const RestorationTolerance* tolerance = ToleranceOf(rubric);
  if (tolerance == nullptr) {
    return Bad("restoration", "the rubric has no tolerances for " + name +
                                  ": add them to \"restorations\", or leave \"restoration\" out");
  }
  for (const scene::RubricCriterion& c : rubric.criteria) {
    if (!DependsOnMaterial(c.metric)) continue;
    if (std::ranges::find(tolerance->criteria, c.metric, &RestorationTolerance::Map::metric) !=
        tolerance->criteria.end())
      continue;
    return Bad("restoration", "what is right for " + c.metric +
                                  " depends on the material, and the tolerances for " + name +
                                  " do not have it: add its map to them, or leave "
                                  "\"restoration\" out");
  }
  return Status::Ok();
}

Rubric WithTolerances(const Rubric& rubric) {
  const RestorationTolerance* tolerance = ToleranceOf(rubric);
  Rubric out = rubric;
  if (tolerance == nullptr) return out;
  for (scene::RubricCriterion& c : out.criteria) {
    const auto map =
        std::ranges::find(tolerance->criteria, c.metric, &RestorationTolerance::Map::metric);
    if (map != tolerance->criteria.end()) c.map = map->map;
  }
  for (scene::RubricCritical& c : out.critical) {
    for (const auto& limit : tolerance->critical) {
      if (limit.error == c.error && limit.metric == c.metric) c.limit = limit.limit;
    }
  }
  return out;
}

Result<std::optional<JudgedLean>> LeanOf(const Rubric& rubric,
                                         const scene::RubricCriterion& criterion,
                                         const MetricSet& metrics) {
  std::optional<JudgedLean> none;
  const RestorationTolerance* tolerance = ToleranceOf(rubric);
  if (tolerance == nullptr || !tolerance->divergence) return none;
  const bool undercut = criterion.metric == kUndercut;
  if (!undercut && criterion.metric != kTilt) return none;
  ENAMEL_ASSIGN_OR_RETURN(const auto walls, Leanings(*tolerance->divergence, metrics));
  if (walls.empty()) return none;
  return std::optional(undercut ? UndercutOf(walls, criterion.map) : TiltOf(walls, criterion.map));
}

}  // namespace enamel::scoring
