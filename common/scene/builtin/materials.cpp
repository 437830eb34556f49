#include "common/scene/material.h"

namespace enamel::scene {
namespace {

using cutting::FeedExponent;
using cutting::Tissue;

// m 1/2: force grows less than linearly with feed where teeth, bone and ceramics were cut, and no fit of teeth was found.
// B at v0 is what is left of the force there beyond Coulomb's part.
constexpr int32_t kFeed_um_per_s = 430;  // the speed of Liu et al. 2008
constexpr const char* kEnamel =
    "chosen: 0.2 N + 2.6 N (v/0.43 mm/s)^(1/2), so that the 2.8 N of Liu et al. 2008 at 0.43 mm/s "
    "hold; "
    "friction 0.5 from ratios of 0.4 to 0.6 in dental ceramics";
constexpr const char* kDentin =
    "chosen: Coulomb's part half and the rest six tenths of enamel's, as B is in Liu et al. 2008";
constexpr const char* kCaries = "chosen: B as for infected dentin, assumed; little friction";
constexpr const char* kPulp = "chosen: soft tissue, not measured";
constexpr const char* kFilling = "chosen: amalgam smears, no figure was found; friction 0.7";

Material::Named Of(Tissue tissue, int32_t damping_mn_s_per_mm, int32_t coulomb_mn,
                   FeedExponent exponent, int32_t friction_permille, const char* provenance) {
  TissueSpec spec{tissue, damping_mn_s_per_mm, provenance};
  spec.coulomb_mn = coulomb_mn;
  spec.feed_exponent = exponent;
  if (exponent != FeedExponent::kOne) spec.feed_um_per_s = kFeed_um_per_s;
  spec.bur_friction_permille = friction_permille;
  return {std::string(cutting::TissueName(tissue)), spec};
}

}  // namespace

const Material& ByLoadMaterial() {
  static const Material material{
      std::string(kByLoad),
      {Of(Tissue::kEnamel, 6'047, 200, FeedExponent::kHalf, 500, kEnamel),
       Of(Tissue::kDentin, 3'628, 100, FeedExponent::kHalf, 500, kDentin),
       Of(Tissue::kPulp, 300, 0, FeedExponent::kOne, 100, kPulp),
       Of(Tissue::kCaries, 1'000, 20, FeedExponent::kOne, 200, kCaries),
       Of(Tissue::kFilling, 6'500, 0, FeedExponent::kOne, 700, kFilling),
       Of(Tissue::kNeighbour, 6'047, 200, FeedExponent::kHalf, 500, kEnamel)}};
  return material;
}

void CutByLoad(Scene* scene) {
  for (TissueSpec& mine : scene->tissues)
    for (const Material::Named& named : ByLoadMaterial().tissues)
      if (named.spec.tissue == mine.tissue) mine = named.spec;
}

}  // namespace enamel::scene
