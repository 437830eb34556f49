#include "common/scene/builtin/rubrics.h"

namespace enamel::scene {
namespace {

constexpr char kUndercut[] = "undercut_deg", kTilt[] = "wall_tilt_deg";

// Degrees beyond the range: the slopes of the rubric's own maps, which begin at 2 degrees.
const std::vector<RubricPoint> kUndercutMap = {{0, 1}, {6, 0}}, kTiltMap = {{0, 1}, {8, 0}};

// Filled in the mouth: undercuts hold amalgam, or do no harm under composite.
RestorationTolerance Filled(Restoration restoration, const char* source,
                            const RestorationTolerance::Ranges& ranges) {
  return {restoration, source, ranges, {{kUndercut, kUndercutMap}, {kTilt, kTiltMap}}, {}};
}

}  // namespace

std::vector<RestorationTolerance> TolerancesOfCavity(bool box) {
  // A box's axial wall is upright for both fillings: beyond it is the pulp.
  const DivergenceRange axial{-2, 2}, ends{-2, 8};
  RestorationTolerance amalgam = Filled(
      Restoration::kAmalgam,
      "Sturdevant's Art and Science of Operative Dentistry; Summitt's Fundamentals of "
      "Operative Dentistry: buccal and lingual walls converge occlusally by up to 5 "
      "degrees, mesial and distal walls diverge. Courses ask for 6 to 8 degrees; beyond 8 few "
      "points go, as Sturdevant allows 10 where the ridge is thin",
      {box ? axial : ends, {-5, 2}});
  RestorationTolerance composite = Filled(
      Restoration::kComposite,
      "Sturdevant's Art and Science of Operative Dentistry; Ben-Amar et al. 1987: bonding holds "
      "composite, so walls may converge or diverge. Mesial and distal walls that lean in still "
      "undermine the marginal ridge",
      {box ? axial : ends, {-5, 10}});
  if (box) {
    // The share is chosen.
    composite.critical = {{"contact_left", "contact_left_percent", 50}};
    composite.source +=
        ". Amalgam needs a contact that is open all round; composite need not break it at the "
        "sides";
  }
  RestorationTolerance ceramic{
      Restoration::kCeramic,
      "Thompson et al. 2010 (review of ceramic inlays); Shillingburg, Fundamentals of Fixed "
      "Prosthodontics: figures from 6 to 20 degrees between opposite walls, here 3 to 10 of each "
      "wall; an undercut does not let the inlay seat, and angles are known to half a degree",
      RestorationTolerance::Ranges{{3, 10}, {3, 10}},
      {{kUndercut, {{0.5, 1}, {2, 0}}}, {kTilt, kTiltMap}},
      {}};
  return {std::move(amalgam), std::move(composite), std::move(ceramic)};
}

}  // namespace enamel::scene
