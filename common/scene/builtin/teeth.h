#pragma once

#include <span>

#include "common/scene/builtin/tooth_shape.h"

// The built-in teeth. Each is a mean tooth of the patient's right side; its mirror image is the
// same tooth of the left (MesialX, tooth_number.h). Lengths, widths and the rise of the cervical
// line are those of the tables in Nelson & Ash, "Wheeler's Dental Anatomy, Physiology and
// Occlusion", 10th edition, 2015 (below, mm). Cusps, grooves, fossae and contacts, their number,
// order and relative size, follow that book and Scheid & Weiss, "Woelfel's Dental Anatomy", 8th
// edition, 2012; tests/common/scene/anatomy_test.cpp states them. Enamel is after Roberson et
// al., "Sturdevant's Art and Science of Operative Dentistry", 5th edition, 2006 (incisal ridge
// of incisors about 2.0, cusps of premolars 2.3 to 2.5, cusps of molars 2.5 to 3, nothing at the
// cervical line), pulp volumes after Fanibunda, Int. Endod. J. 19, 1986 (mm^3), the molar's
// chamber after Deutsch & Musikant, J. Endod. 30, 2004 (roof 6.4 below the buccal cusps, 1.6 +-
// 0.7 high). Section curves are drawn so that scanned crowns of the same type lie near
// (tests/common/scene/teeth_test.cpp says how near).
//
//                               crown   root    mesiodistal     buccolingual   cervical rise  pulp
//                               length  length  crown  cervix   crown  cervix  m.    d.      volume
//   lower first molar (46)      7.5     14.0    11.0   9.0      10.5   9.0     1.0   0.0     53
//   upper first premolar (14)   8.5     14.0     7.0   5.0       9.0   8.0     1.0   0.0     18
//   upper central incisor (11)  10.5    13.0     8.5   7.0       7.0   6.0     3.5   2.5     12
// The primary molar's crown is within two deviations of 41 lower second primary molars in cone-beam
// tomograms (Hanoi Medical University 2025, abstract, mean and deviation: crown height 5.5 +- 0.4, mesiodistal
// 10.4 +- 0.6 and 7.6 +- 0.6 at the neck, buccolingual 9.2 +- 0.5). Chosen: a millimetre of enamel, horns
// 3.6 mm below the cusps (micro-CT of upper second primary molars, Lokman Hekim University 2015: 2.8 to
// 3.8 mm of dentin over the chamber), roots.
namespace enamel::scene {

const ToothShape& LowerFirstMolar();
const ToothShape& LowerLeftFirstMolar();  // its mirror image
const ToothShape& PrimarySecondMolar();
const ToothShape& UpperFirstPremolar();
const ToothShape& UpperCentralIncisor();

// All of them.
std::span<const ToothShape* const> BuiltinTeeth();

}  // namespace enamel::scene
