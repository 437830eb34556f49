#pragma once

#include <vector>

#include "station/render/mesher.h"

namespace enamel::station::mouth {

// Interincisal opening of the mouth in the picture. Less than 40 mm, unassisted and without pain, is
// a limited opening (RDC/TMD: Dworkin & LeResche, J. Craniomandib. Disord. 6, 1992).
inline constexpr double kOpening_mm = 40;

// The teeth opposite to `tooth`, one and its neighbours, with their gingiva, only to look at. In the
// frame of the tooth, crown up, millimetres; the jaw is open by kOpening_mm. `top_mm`: of the tooth's
// crown. None for deciduous teeth. Requires: IsToothNumber(tooth).
std::vector<render::GroupMesh> AntagonistOf(int tooth, double top_mm);

}  // namespace enamel::station::mouth
