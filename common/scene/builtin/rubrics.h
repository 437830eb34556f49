#pragma once

#include <string>
#include <vector>

#include "common/scene/types.h"

// The rubrics of the built-in exercises and their parts.
namespace enamel::scene {

// How far a side of a cavity may go beyond the line. The exercise's text states it, the rubric's
// points for the side end there, and page and window show it as a zone.
inline constexpr int32_t kLeeway_um = 250;
// And how far off it may be with full marks.
inline constexpr int32_t kRight_um = 30;

// Full marks up to `full`, none from `none` on; and the other way.
RubricCriterion AtMost(const char* metric, const char* title, const char* unit, double points,
                       double full, double none, const char* comment);
RubricCriterion AtLeast(const char* metric, const char* title, const char* unit, double points,
                        double none, double full, const char* comment);
RubricCriterion WallCriterion(const char* metric, const char* title, double points,
                              const char* comment);
RubricCriterion PulpCriterion(double points);
// Full marks from 99.5 % of the caries that the reference took.
RubricCriterion NoCariesCriterion(double points);
RubricGate CariesGate();
// Less than 0.5 mm of dentin is taken as too little to protect the pulp (schemas/score.md).
RubricCriterion CoverCriterion(double points);

// A criterion earns only in so far as the task was done, the rest of the mouth is still there, and
// nothing has a hole that does not belong to the task.
std::vector<RubricGate> TaskGates();

// `tooth`: there is a pulp to keep.
Rubric ClassOneRubric(bool tooth);
// For shapes whose walls are not a box's: the distance to the reference says it all.
struct TimeBand {
  double full_s = 300, none_s = 900;
};
Rubric ShapeRubric(std::string name, double closeness = 30, double nowhere = 15,
                   TimeBand time = {});
// Caries goes, sound tissue stays, the pulp is kept covered. The task is what the reference took:
// the share of it that is left is judged, not how much was taken.
Rubric CariesRubric();
Rubric CrownRubric(bool anterior);

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
// whose axial wall is the one towards the middle of the tooth.
std::vector<RestorationTolerance> TolerancesOfCavity(bool box);
void AddCritical(Rubric& rubric, const std::vector<RubricCritical>& critical);

}  // namespace enamel::scene
