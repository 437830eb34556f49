#include "common/core/core.h"
#include "common/core/quantise.h"

// Counts and whole nanometres to places in the scene; the rest point of a board's spring among them.
namespace enamel::core {
namespace {

std::array<int64_t, 3> CountsNm(const std::array<int32_t, 3>& counts,
                                const CoreParams& p) noexcept {
  std::array<int64_t, 3> nm;
  for (size_t i = 0; i < 3; ++i) nm[i] = int64_t{counts[i]} * p.resolution_nm[i];
  return nm;
}

}  // namespace

dvec3 Core::TipOf(const std::array<int32_t, 3>& counts) const noexcept {
  return PlaceOf(CountsNm(counts, params_));
}

dvec3 Core::PlaceOf(const std::array<int64_t, 3>& nm) const noexcept {
  dvec3 out;
  for (int i = 0; i < 3; ++i) {
    auto n = static_cast<size_t>(i);
    // Whole nanometres stay below 2^53 for any 32-bit count (ValidateParams bounds cell and
    // origin), so the product below is the only rounding.
    out[i] = static_cast<double>(params_.device_origin_nm[n] + nm[n]) * 1e-9;
  }
  return out;
}

std::array<int64_t, 3> Core::ExpectedRest_nm(const std::array<int32_t, 3>& counts) const noexcept {
  const SpringWish& wish = wishes_[(ticks_ + kWishes - 1 - params_.bus_delay_ticks) % kWishes];
  if (!wish.on || wish.follow) return CountsNm(counts, params_);
  return {wish.rest_nm[0], wish.rest_nm[1], wish.rest_nm[2]};
}

std::array<int32_t, 3> Core::RestOff_nm(const std::array<int32_t, 3>& counts,
                                        const std::array<int32_t, 3>& rest_nm) const noexcept {
  const std::array<int64_t, 3> expected = ExpectedRest_nm(counts);
  std::array<int32_t, 3> off;
  for (size_t i = 0; i < 3; ++i) off[i] = Quantise(static_cast<double>(rest_nm[i] - expected[i]));
  return off;
}

void Core::TakeSpring(const TickInput& input, TickOutput& out) noexcept {
  constexpr double kShare = 65535;
  std::array<int64_t, 3> rest = ExpectedRest_nm(input.counts);
  for (size_t i = 0; i < 3; ++i) {
    rest[i] += input.rest_off_nm[i];
    if (input.rest_off_nm[i] != 0) out.flags |= haptics::kGuardEngaged;
  }
  coupling_.TakeSpring(PlaceOf(rest), 1 - input.share_lost / kShare);
}

}  // namespace enamel::core
