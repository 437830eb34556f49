#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "common/base/result.h"
#include "common/math/orientation.h"
#include "common/math/vec.h"

namespace enamel::station::hid {

// Directions of a board's axes in the scene: scene axis i is board axis |from[i]| - 1, negated
// where from[i] < 0. A proper rotation: mirrored ones are refused. Real-time: ToScene and ToBoard
// are safe.
struct AxisMap {
  std::array<int, 3> from{1, 2, 3};

  std::array<int32_t, 3> ToScene(const std::array<int32_t, 3>& board) const noexcept;
  dvec3 ToBoard(const dvec3& scene) const noexcept;
  // The tool's orientation: the same rotation seen from the scene.
  Quat ToScene(const Quat& board) const noexcept;
};

// "+x+y+z", "-y+x+z": the board axis for scene x, y, z. Errors: kInvalidInput, also for a mirror
// image or an axis named twice.
Result<AxisMap> ParseAxisMap(std::string_view text);

}  // namespace enamel::station::hid
