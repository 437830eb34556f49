#include <algorithm>

#include "common/scene/builtin/rubrics.h"

namespace enamel::scene {
namespace {

// A wall's price with other sizes.
RubricPrice Wall(double over_mm, double left_mm) {
  std::vector<RubricPrice> prices = PricesOfCavity();
  RubricPrice wall = *std::ranges::find(prices, "wall", &RubricPrice::of);
  wall.over = over_mm, wall.left = left_mm;
  return wall;
}

}  // namespace

std::vector<RestorationTolerance> TolerancesOfCavity(bool box) {
  RestorationTolerance amalgam{
      Restoration::kAmalgam,
      "Sturdevant's Art and Science of Operative Dentistry; Summitt's Fundamentals of Operative "
      "Dentistry: walls hold amalgam; the rubric's own prices count",
      {},
      {}};
  RestorationTolerance composite{
      Restoration::kComposite,
      "Sturdevant's Art and Science of Operative Dentistry; Ben-Amar et al. 1987: bonding holds "
      "composite, so walls may converge or diverge; the sizes are chosen",
      {Wall(0.6, 0.7)},
      {}};
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
      "Prosthodontics: an undercut does not let the inlay seat; the sizes are chosen",
      {Wall(0.45, 0.45)},
      {}};
  return {std::move(amalgam), std::move(composite), std::move(ceramic)};
}

}  // namespace enamel::scene
