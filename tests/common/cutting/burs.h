#pragma once

#include <vector>

#include "common/cutting/bur.h"

namespace enamel::test {

// One of each shape, of ordinary size.
inline std::vector<cutting::Bur> AllBurs() {
  using cutting::BurShape;
  return {{BurShape::kSphere, 0.5e-3},
          {BurShape::kCylinder, 0.6e-3, 4e-3},
          {BurShape::kCone, 0.8e-3, 4e-3, 0.4e-3},
          {BurShape::kCone, 0.6e-3, 3e-3, 0},
          {BurShape::kInvertedCone, 0.6e-3, 1.5e-3, 0.4e-3},
          {BurShape::kPear, 0.5e-3, 2e-3, 0.3e-3},
          {BurShape::kFlame, 0.6e-3, 3.5e-3, 0.3e-3},
          {BurShape::kWheel, 1.5e-3, 0.6e-3}};
}

}  // namespace enamel::test
