#pragma once

#include <cstdint>
#include <vector>

#include "common/cutting/bur.h"
#include "station/render/mesher.h"

// Bodies of revolution to draw, about +z, in millimetres.
namespace enamel::station::render {

// Values of GpuVertex::tissue beyond the tissues.
enum Material : uint8_t { kBurHead = 8, kBurShank = 9, kForceArrow = 10 };

struct Shape {
  std::vector<GpuVertex> vertices;
  std::vector<uint32_t> indices;
};

// The bur in its own frame: cutting head exactly as the core cuts, then neck and shank, which are
// for the eye only.
Shape BurHeadShape(const cutting::Bur& bur);
Shape BurShankShape(const cutting::Bur& bur);
// Unit cylinder and unit cone along +z, radius 1.
Shape ShaftShape();
Shape TipShape();

}  // namespace enamel::station::render
