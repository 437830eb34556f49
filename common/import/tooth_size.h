#pragma once

namespace enamel::import {

// A mean crown: from cervical line to cusp or edge, mesial to distal, and buccal to lingual, mm.
// Nelson & Ash, "Wheeler's Dental Anatomy, Physiology and Occlusion", 10th ed. 2015, the tables of
// measurements of permanent and primary teeth.
struct ToothSize {
  double height_mm, mesiodistal_mm, buccolingual_mm;
};
// Requires: scene::IsToothNumber.
const ToothSize& MeanSize(int tooth);

}  // namespace enamel::import
