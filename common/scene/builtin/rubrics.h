#pragma once

#include <string>
#include <vector>

#include "common/scene/types.h"

// The rubrics of the built-in exercises and their parts.
namespace enamel::scene {

// How far a side of a cavity may go beyond the line. The exercise's text states it, and page and
// window show it as a zone.
inline constexpr int32_t kLeeway_um = 250;

// Prices of the regions of a cavity, a stump or a face, each with those of damage to the tooth.
std::vector<RubricPrice> PricesOfCavity();
std::vector<RubricPrice> PricesOfStump();
std::vector<RubricPrice> PricesOfFace();
RubricPrice PriceOfCaries();
// Prices for a target of any form.
std::vector<RubricPrice> AllPrices();

struct TimeBand {
  double full_s = 300, none_s = 900;
};
// The most points that pressing hard and taking long cost.
std::vector<RubricCriterion> HandCriteria(double force, double time, const TimeBand& band = {});

// `tooth`: there is a pulp to keep.
Rubric ClassOneRubric(bool tooth);
Rubric ShapeRubric(std::string name, const TimeBand& time = {});
// Caries goes, sound tissue stays, the pulp is kept covered.
Rubric CariesRubric();
Rubric CrownRubric();

// Critical errors, each with the source of its limit (critical.cpp). OfAny is in every rubric, and
// in OfCavity.
std::vector<RubricCritical> CriticalOfAny();
std::vector<RubricCritical> CriticalOfPulp();
std::vector<RubricCritical> CriticalOfCavity();
std::vector<RubricCritical> CriticalOfWidth(bool open_mesial);
std::vector<RubricCritical> CriticalOfContact();
std::vector<RubricCritical> CriticalOfCaries();
std::vector<RubricCritical> CriticalOfCrown();
std::vector<RubricCritical> CriticalOfFace();
// What amalgam, composite and ceramic tolerate in a cavity (restorations.cpp). `box`: of class II,
// which opens a contact.
std::vector<RestorationTolerance> TolerancesOfCavity(bool box);
void AddCritical(Rubric& rubric, const std::vector<RubricCritical>& critical);

}  // namespace enamel::scene
