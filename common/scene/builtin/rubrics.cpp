#include "common/scene/builtin/rubrics.h"

#include <utility>

namespace enamel::scene {
namespace {

// Examinations state sizes that pass and fail, and no points for them. The prices are chosen: 0.3 mm too far over all of a
// wall or floor costs 5.3 or 6.2 points, 1 mm 20 or 23 (prices_test).
constexpr char kChosen[] = "chosen";

// An examiner asks for a new cut from about `over_mm` or `left_mm` on.
RubricPrice OfRegion(const char* of, double over_mm, double left_mm, double points, double times) {
  return {of, over_mm, left_mm, points, points * times, points / 6, points, kChosen};
}

RubricCriterion AtMost(const char* metric, const char* title, const char* unit, double points,
                       double full, double none, const char* comment) {
  return {metric, title, unit, points, {{full, 1}, {none, 0}}, comment, {}};
}

std::vector<RubricPrice> WithDamage(std::vector<RubricPrice> regions) {
  // 1 mm3 is a bur's width, as deep; 0.25 mm into a neighbour over 1 mm2 is ten points.
  regions.push_back({"elsewhere", 1, 0, 12, 60, 2, 12, kChosen});
  regions.push_back({"neighbour", 1, 0, 40, 40, 2, 10, kChosen});
  regions.push_back({"pulp", 0.05, 0, 50, 50, 0.5, 5, kChosen});
  // A third of a contact that is not opened at all costs 8.5 points, and 60 % of one is to be redone.
  regions.push_back({"contact", 0, 50, 6, 12, 1, 6, kChosen});
  return regions;
}

}  // namespace

std::vector<RubricPrice> PricesOfCavity() {
  RubricPrice edges = OfRegion("line_angle", 0.6, 0.6, 5, 1.2);
  return WithDamage(
      {OfRegion("floor", 0.45, 0.6, 14, 3), OfRegion("wall", 0.45, 0.6, 12, 3), std::move(edges)});
}

std::vector<RubricPrice> PricesOfStump() {
  return WithDamage({OfRegion("table", 0.45, 0.45, 6, 3), OfRegion("axial_wall", 0.4, 0.4, 7, 3),
                     OfRegion("margin", 0.3, 0.4, 4, 3), OfRegion("line_angle", 0.6, 0.6, 5, 1.2)});
}

std::vector<RubricPrice> PricesOfFace() {
  return WithDamage({OfRegion("face", 0.3, 0.3, 12, 3), OfRegion("line_angle", 0.6, 0.6, 5, 1.2)});
}

RubricPrice PriceOfCaries() { return {"caries", 0, 50, 60, 60, 6, 24, kChosen}; }

std::vector<RubricPrice> AllPrices() {
  std::vector<RubricPrice> out = PricesOfCavity();
  for (const auto& more : {PricesOfStump(), PricesOfFace()}) {
    for (const RubricPrice& price : more) {
      bool known = false;
      for (const RubricPrice& p : out) known = known || p.of == price.of;
      if (!known) out.push_back(price);
    }
  }
  return out;
}

std::vector<RubricCriterion> HandCriteria(double force, double time, const TimeBand& band) {
  return {AtMost("force_sent_p95_n", "Light hand", "N", force, 4, 8,
                 "The bur was pressed too hard: let it cut."),
          AtMost("time_s", "Time", "s", time, band.full_s, band.none_s, "The work took too long.")};
}

Rubric ClassOneRubric(bool tooth) {
  Rubric r;
  r.name = "class-1-occlusal";
  r.prices = PricesOfCavity();
  r.criteria = HandCriteria(4, 3, {240, 600});
  r.critical = tooth ? CriticalOfCavity() : CriticalOfAny();
  if (tooth) {
    AddCritical(r, CriticalOfPulp());
    AddCritical(r, CriticalOfWidth(false));
    r.restoration = Restoration::kAmalgam;
    r.restorations = TolerancesOfCavity(false);
  }
  return r;
}

Rubric ShapeRubric(std::string name, const TimeBand& time) {
  Rubric r;
  r.name = std::move(name);
  r.prices = PricesOfCavity();
  r.criteria = HandCriteria(10, 5, time);
  r.critical = CriticalOfAny();
  return r;
}

Rubric CariesRubric() {
  Rubric r;
  r.name = "caries-excavation";
  r.prices = AllPrices();
  r.prices.push_back(PriceOfCaries());
  r.criteria = HandCriteria(5, 5);
  r.critical = CriticalOfAny();
  AddCritical(r, CriticalOfPulp());
  AddCritical(r, CriticalOfCaries());
  return r;
}

Rubric CrownRubric() {
  Rubric r = ShapeRubric("crown-preparation", {1'200, 2'400});
  r.prices = PricesOfStump();
  // Where the crown is cut away, the pulp is open too.
  AddCritical(r, CriticalOfCrown());
  AddCritical(r, CriticalOfPulp());
  return r;
}

}  // namespace enamel::scene
