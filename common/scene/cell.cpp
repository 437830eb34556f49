#include "common/scene/cell.h"

namespace enamel::scene {
namespace {

// ceil(n sqrt(3)/2): at most 2e9 nm come in, so the product fits.
int64_t HalfDiagonal(int64_t n) { return (n * 866'025'404 + 999'999'999) / 1'000'000'000; }

}  // namespace

int32_t CountNm(const DeviceProfile& profile) {
  return profile.cell ? profile.cell->count_nm : static_cast<int32_t>(profile.resolution_nm.value);
}

TipCellNm TipCellOf(const DeviceProfile& profile) {
  const int64_t delta = profile.resolution_nm.value, count = CountNm(profile);
  const int64_t noise = profile.cell ? profile.cell->noise_counts : 0;
  const int64_t wide = delta * (1 + 2 * noise);  // of the cell with its noise
  const int64_t rounding = (count + 1) / 2;
  TipCellNm cell;
  if (profile.cell && profile.cell->joints) {
    cell.half_nm = static_cast<int32_t>(rounding);
    cell.ball_nm = static_cast<int32_t>(HalfDiagonal(wide));
  } else {
    cell.half_nm = static_cast<int32_t>((wide + 1) / 2 + (count == delta ? 0 : rounding));
  }
  return cell;
}

int32_t CellSupportNm(const DeviceProfile& profile) {
  const TipCellNm cell = TipCellOf(profile);
  if (!profile.cell || !profile.cell->joints) return cell.half_nm + cell.ball_nm;
  return static_cast<int32_t>(HalfDiagonal(2 * int64_t{cell.half_nm})) + cell.ball_nm;
}

}  // namespace enamel::scene
