#include "station/render/materials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "station/render/revolve.h"

namespace enamel::station::render {
namespace {

glm::vec3 Linear(int r, int g, int b) {
  return glm::pow(glm::vec3(r, g, b) / 255.0f, glm::vec3(2.2f));
}

// By cutting::Tissue, then Material.
std::array<glm::vec3, 16> Colours() {
  std::array<glm::vec3, 16> c;
  c.fill(Linear(255, 0, 255));
  c[1] = Linear(242, 234, 214);  // enamel: ivory
  c[2] = Linear(226, 187, 116);  // dentin: yellower
  c[3] = Linear(186, 46, 48);    // pulp
  c[4] = Linear(112, 74, 44);    // caries
  c[5] = Linear(190, 196, 206);  // filling
  c[6] = Linear(226, 222, 212);  // gypsum
  c[7] = Linear(222, 214, 196);  // neighbour
  c[kBurHead] = Linear(150, 170, 205);
  c[kBurShank] = Linear(176, 186, 204);
  c[kForceArrow] = Linear(40, 205, 190);
  c[kTargetLine] = Linear(20, 96, 235);
  // Coral pink, red with vessels, and the picture's background; the shader mixes them.
  c[kGingiva] = Linear(226, 148, 138);
  c[kGingiva + 1] = Linear(168, 70, 66);
  c[kGingiva + 2] = Linear(26, 22, 24);
  // Dark green, the makers' usual colour beside blue: the target's line is blue.
  c[15] = Linear(38, 112, 92);
  return c;
}

std::array<float, 16> Gloss() {
  std::array<float, 16> g;
  g.fill(0.25f);
  g[1] = 0.8f;  // wet
  g[2] = 0.5f;
  g[3] = 0.6f;
  g[4] = 0.1f;  // soft
  g[7] = 0.7f;
  g[kBurHead] = g[kBurShank] = 1.0f;
  g[kForceArrow] = g[kTargetLine] = 0.1f;
  // Wet, and duller into the dark.
  g[kGingiva] = 0.7f, g[kGingiva + 1] = 0.6f, g[kGingiva + 2] = 0;
  g[15] = 0.06f;  // matt
  return g;
}

}  // namespace

glm::vec3 TissueColour(cutting::Tissue tissue) {
  static const auto colours = Colours();
  return colours[static_cast<size_t>(tissue)];
}
double TissueGloss(cutting::Tissue tissue) {
  static const auto gloss = Gloss();
  return static_cast<double>(gloss[static_cast<size_t>(tissue)]);
}

LesionColours Lesion() { return {Linear(248, 248, 242), Linear(178, 124, 60)}; }

glm::vec3 StainColour() { return Linear(104, 84, 66); }

void SetMaterials(const Program& program) {
  program.Set("colours", std::span<const glm::vec3>(Colours()));
  program.Set("gloss", std::span<const float>(Gloss()));
}

namespace {

// ColorBrewer RdBu, its middle a little warmer; then what was not compared.
constexpr std::array<uint32_t, kDeviationSteps + 1> kDeviation = {
    0x053061, 0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf6f1e4,
    0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b, 0x67001f, 0xa3abb5};

}  // namespace

uint8_t DeviationMaterial(double deviation_mm) {
  constexpr double kLast = kDeviationSteps - 1;
  const double place = 0.5 * (deviation_mm / kDeviationRange_mm + 1) * kLast;
  return static_cast<uint8_t>(std::lround(std::clamp(place, 0.0, kLast)));
}

uint32_t DeviationColour(int material) { return kDeviation[static_cast<size_t>(material)]; }

void SetDeviationMaterials(const Program& program) {
  std::array<glm::vec3, 16> colours{};
  for (size_t i = 0; i < kDeviation.size(); ++i) {
    const auto c = static_cast<int>(kDeviation[i]);
    colours[i] = Linear(c >> 16, (c >> 8) & 255, c & 255);
  }
  std::array<float, 16> gloss{};  // a highlight would be one more colour
  program.Set("colours", std::span<const glm::vec3>(colours));
  program.Set("gloss", std::span<const float>(gloss));
}

glm::vec3 GhostColour() { return Linear(90, 150, 255); }

}  // namespace enamel::station::render
