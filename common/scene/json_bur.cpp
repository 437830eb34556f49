#include "common/scene/json_bur.h"

#include <boost/json.hpp>

namespace enamel::scene {

boost::json::object BurJson(const BurSpec& bur) {
  return {{"shape", cutting::BurShapeName(bur.shape)},
          {"radius_um", bur.radius_um},
          {"length_um", bur.length_um}};
}

BurSpec ReadBur(ObjectReader& in) {
  BurSpec bur;
  std::string shape = in.Name("shape");
  auto known = cutting::BurShapeFromName(shape);
  if (!known) in.Refuse("shape", "sphere or cylinder", "\"" + shape + "\"");
  bur.shape = known.value_or(cutting::BurShape::kSphere);
  bur.radius_um = static_cast<int32_t>(in.Int("radius_um", 50, 5'000));
  bool sphere = bur.shape == cutting::BurShape::kSphere;
  bur.length_um = static_cast<int32_t>(in.Int("length_um", sphere ? 0 : 100, 20'000));
  return bur;
}

}  // namespace enamel::scene
