#pragma once

#include "common/cutting/tissue.h"
#include "station/render/gl_objects.h"

namespace enamel::station::render {

// Linear; of enamel and dentin those of an endless layer (tooth_looks.h).
glm::vec3 TissueColour(cutting::Tissue tissue);
// Of an uncut surface.
double TissueGloss(cutting::Tissue tissue);
// What a bur leaves of it.
inline constexpr double kCutGloss = 0.2;

// Of a lesion, beside that of caries: its border in enamel, and in dentin.
struct LesionColours {
  glm::vec3 chalk, soft;
};
LesionColours Lesion();
// Of fissures and pits.
glm::vec3 StainColour();

// Colours and gloss of the tissues and of Material (revolve.h), for the program in use.
void SetMaterials(const Program& program);

// The scale of a deviation map, the page's: blue where less was removed than in the reference, red
// where more was, in steps of a tenth of a millimetre; beyond it the end's colour.
inline constexpr int kDeviationSteps = 11;
inline constexpr double kDeviationRange_mm = 0.5;
inline constexpr uint8_t kUntouched = kDeviationSteps;  // the material of what was not compared
// The material of a vertex, for SetDeviationMaterials.
uint8_t DeviationMaterial(double deviation_mm);
// sRGB, 0xRRGGBB.
uint32_t DeviationColour(int material);
void SetDeviationMaterials(const Program& program);

// The ghost of the hand.
glm::vec3 GhostColour();

}  // namespace enamel::station::render
