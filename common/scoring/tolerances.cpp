#include "common/scoring/tolerances.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "common/scene/restoration.h"
#include "common/scoring/mistakes/prices.h"

namespace enamel::scoring {
namespace {

using scene::RestorationTolerance;
using scene::Rubric;

Status Bad(const std::string& field, const std::string& message) {
  return Status(Code::kInvalidInput, "rubric, " + field + ": " + message, field);
}

const RestorationTolerance* ToleranceOf(const Rubric& rubric) {
  if (rubric.restoration == scene::Restoration::kNone) return nullptr;
  const auto it = std::ranges::find(rubric.restorations, rubric.restoration,
                                    &RestorationTolerance::restoration);
  return it == rubric.restorations.end() ? nullptr : &*it;
}

Status ValidateOne(const Rubric& rubric, const RestorationTolerance& t, const std::string& place) {
  ENAMEL_RETURN_IF_ERROR(ValidatePrices(t.prices, place + ".prices"));
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
  return Status::Ok();
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
  return Status::Ok();
}

Rubric WithTolerances(const Rubric& rubric) {
  const RestorationTolerance* tolerance = ToleranceOf(rubric);
  Rubric out = rubric;
  if (tolerance == nullptr) return out;
  for (const scene::RubricPrice& price : tolerance->prices) {
    const auto own = std::ranges::find(out.prices, price.of, &scene::RubricPrice::of);
    if (own != out.prices.end())
      *own = price;
    else
      out.prices.push_back(price);
  }
  for (scene::RubricCritical& c : out.critical) {
    for (const auto& limit : tolerance->critical) {
      if (limit.error == c.error && limit.metric == c.metric) c.limit = limit.limit;
    }
  }
  return out;
}

}  // namespace enamel::scoring
