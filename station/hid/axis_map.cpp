#include "station/hid/axis_map.h"

#include <cstdlib>
#include <string>

namespace enamel::station::hid {
namespace {

// -1 x INT32_MIN would overflow.
int32_t Negated(int32_t v) noexcept { return v == INT32_MIN ? INT32_MAX : -v; }

size_t Board(int from) noexcept { return static_cast<size_t>(from < 0 ? -from : from) - 1; }

// 1: a rotation. -1: a mirror image. 0: an axis named twice, since then a column is empty.
int Determinant(const std::array<int, 3>& from) {
  int m[3][3] = {};
  for (size_t i = 0; i < 3; ++i) m[i][Board(from[i])] = from[i] < 0 ? -1 : 1;
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

}  // namespace

std::array<int32_t, 3> AxisMap::ToScene(const std::array<int32_t, 3>& board) const noexcept {
  std::array<int32_t, 3> out{};
  for (size_t i = 0; i < 3; ++i) {
    out[i] = from[i] < 0 ? Negated(board[Board(from[i])]) : board[Board(from[i])];
  }
  return out;
}

dvec3 AxisMap::ToBoard(const dvec3& scene) const noexcept {
  dvec3 out(0);
  for (int i = 0; i < 3; ++i) {
    int f = from[static_cast<size_t>(i)];
    out[static_cast<int>(Board(f))] = f < 0 ? -scene[i] : scene[i];
  }
  return out;
}

Quat AxisMap::ToScene(const Quat& board) const noexcept {
  // A rotation turns the axis of a turn like any vector and keeps its angle. A mirror image would
  // not.
  const double v[3] = {board.x, board.y, board.z};
  double out[3];
  for (size_t i = 0; i < 3; ++i) out[i] = from[i] < 0 ? -v[Board(from[i])] : v[Board(from[i])];
  return {out[0], out[1], out[2], board.w};
}

Result<AxisMap> ParseAxisMap(std::string_view text) {
  AxisMap map;
  bool ok = text.size() == 6;
  for (size_t i = 0; ok && i < 3; ++i) {
    char sign = text[2 * i], axis = text[2 * i + 1];
    ok = (sign == '+' || sign == '-') && axis >= 'x' && axis <= 'z';
    map.from[i] = (sign == '-' ? -1 : 1) * (axis - 'x' + 1);
  }
  if (!ok || Determinant(map.from) != 1) {
    return Status(
        Code::kInvalidInput,
        "expected which board axis is scene x, y and z, as +x+y+z or -y+x+z, no axis twice "
        "and no mirror image; found '" +
            std::string(text) + "'",
        "axes");
  }
  return map;
}

}  // namespace enamel::station::hid
