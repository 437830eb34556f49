#pragma once

#include <string>
#include <vector>

#include "common/scoring/mistakes/fault_volumes.h"

// How an attempt's surface came to be off R's: as few motions and shapes as explain it. The
// deviation d of each piece of R's surface (mm; + cut too far, - left) is fitted by a sum of named
// motions phi_k, each with a size beta_k:
//
//     minimise  1/2 sum_i A_i (d_i - sum_k beta_k phi_k(i))^2 + sum_k lambda_k |beta_k| + eps/2 |beta|^2
//
// (elastic_net.h): nothing jumps where two explanations are about as good. Each phi is scaled to unit norm first. Motions
// of the whole have the smallest lambda, motions of one region a larger one, and patches the largest.
//
// Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

enum class MotionKind : uint8_t {
  kShiftX,  // of the whole, mm
  kShiftY,
  kTurn,  // about the way in, degrees
  kTipX,  // about x and y, degrees
  kTipY,
  kSize,    // all walls, mm: + over-extended, of a stump over-reduced
  kTaper,   // all walls open towards the top, degrees; a stump's converge
  kHeight,  // all floors, tables or margins of one kind, mm: + too deep
  kOffset,  // of one region, mm
  kLean,    // of one wall, degrees
  kSlopeX,  // of floors or the table, degrees
  kSlopeY,
  kPart,   // of one region, to one side of a line, mm
  kStrip,  // of a wall, from its foot to its rim, mm
  kPatch,  // a bump, mm
};

struct Displacement {
  MotionKind kind = MotionKind::kOffset;
  int region = -1;           // of one region; -1: of the whole or a kind
  RegionKind of{};           // kHeight and slopes: of all regions of this kind
  dvec3 at_m{0};             // kPart and kStrip: its middle; kPatch
  double size = 0;           // of the fit, in its unit
  std::vector<double> d_mm;  // what it explains at each piece: beta phi
};

// The motions that explain a part of `off_mm` (FaultVolumes::off_m), in the order of the dictionary.
std::vector<Displacement> Explain(const AcceptableCut& r, const std::vector<double>& off_mm);

}  // namespace enamel::scoring
