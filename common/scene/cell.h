#pragma once

#include <cstdint>

#include "common/scene/types.h"

// The tip's cell: where the true tip can be around a recorded position, as the guard counts with it
// (common/haptics/README.md, "The cell"). In whole nanometres, rounded up: station and server arrive at the
// same numbers, and never at less than there is.
// Thread safety: functions, any thread. Real-time: not safe.
namespace enamel::scene {

// Box along the axes of space and ball, added up: haptics::TipCell::half_m (each axis) and ball_m.
struct TipCellNm {
  int32_t half_nm = 0, ball_nm = 0;

  bool operator==(const TipCellNm&) const = default;
};

// Edge of a recorded count, nm: what CoreParams::resolution_nm is.
int32_t CountNm(const DeviceProfile& profile);

// With cells of edge delta, counts of edge q and n counts of noise:
//   along the axes   half = delta (1/2 + n), and q/2 more where q is not delta
//   at the joints    ball = sqrt(3) delta (1/2 + n), half = q/2
// Requires: a profile as its document may say.
TipCellNm TipCellOf(const DeviceProfile& profile);

// S of c >= Kc S, nm: the friction c that pays for the cell, per axis of the friction. It acts along the
// axes, or at the joints where those count: there the box costs its diagonal, half + ball becomes
// sqrt(3) half + ball.
int32_t CellSupportNm(const DeviceProfile& profile);

}  // namespace enamel::scene
