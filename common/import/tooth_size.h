#pragma once

namespace enamel::import {

// A typical crown: from cervical line to cusp or edge, mesial to distal, and buccal to lingual, mm. Chosen: sizes of the
// order that textbooks of dental anatomy print. No table was read for them.
struct ToothSize {
  double height_mm, mesiodistal_mm, buccolingual_mm;
};
// Requires: scene::IsToothNumber.
const ToothSize& MeanSize(int tooth);

}  // namespace enamel::import
