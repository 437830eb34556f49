#include "common/scene/json/tissue.h"

#include <array>
#include <utility>

namespace enamel::scene {
namespace {

using cutting::FeedExponent;

constexpr int64_t kMaxDamping = 1'000'000'000, kMaxForce_mn = 100'000,
                  kMaxFeed_um_per_s = 1'000'000;
constexpr int64_t kMaxFriction_permille = 2'000;
constexpr std::array kExponents = {std::pair{FeedExponent::kNone, "0"},
                                   std::pair{FeedExponent::kHalf, "1/2"}};

FeedExponent ReadExponent(ObjectReader& in) {
  const std::string text = in.Text("feed_exponent", 1, 8);
  for (const auto& [exponent, name] : kExponents)
    if (text == name) return exponent;
  in.Refuse("feed_exponent", "0 or 1/2; left out it is 1", text);
  return FeedExponent::kOne;
}

}  // namespace

void ReadTissueLaw(ObjectReader& in, TissueSpec& spec) {
  auto read = [&](const char* name, int64_t most, int32_t& value) {
    if (in.Has(name)) value = static_cast<int32_t>(in.Int(name, 1, most));
  };
  spec.damping_mn_s_per_mm = static_cast<int32_t>(in.Int("damping_mn_s_per_mm", 1, kMaxDamping));
  read("axial_damping_mn_s_per_mm", kMaxDamping, spec.axial_damping_mn_s_per_mm);
  read("coulomb_mn", kMaxForce_mn, spec.coulomb_mn);
  if (in.Has("feed_exponent")) {
    spec.feed_exponent = ReadExponent(in);
    spec.feed_um_per_s = static_cast<int32_t>(in.Int("feed_um_per_s", 1, kMaxFeed_um_per_s));
  }
  read("bur_friction_permille", kMaxFriction_permille, spec.bur_friction_permille);
}

void WriteTissueLaw(const TissueSpec& spec, boost::json::object& out) {
  auto write = [&](const char* name, int32_t value) {
    if (value != 0) out[name] = value;
  };
  out["damping_mn_s_per_mm"] = spec.damping_mn_s_per_mm;
  write("axial_damping_mn_s_per_mm", spec.axial_damping_mn_s_per_mm);
  write("coulomb_mn", spec.coulomb_mn);
  for (const auto& [exponent, name] : kExponents)
    if (spec.feed_exponent == exponent) out["feed_exponent"] = name;
  if (spec.feed_exponent != FeedExponent::kOne) write("feed_um_per_s", spec.feed_um_per_s);
  write("bur_friction_permille", spec.bur_friction_permille);
}

}  // namespace enamel::scene
