#include <algorithm>
#include <array>
#include <boost/json.hpp>

#include "common/scene/json.h"
#include "common/scene/json_read.h"
#include "common/scene/json_text.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

// Format 2 adds what may be unknown, format 3 whether the delay was measured; a document without
// any of it is written as format 1.
constexpr int64_t kFormat = 1, kFormatOptional = 2, kFormatMeasured = 3;
constexpr std::string_view kDelay = "bus_delay_ticks", kMeasured = "measured";

struct Number {
  const char* name;
  Sourced DeviceProfile::*member;
  int64_t lo, hi;
};

// The order is that of the canonical document.
constexpr std::array<Number, 11> kNumbers = {{
    {"resolution_nm", &DeviceProfile::resolution_nm, 1, 1'000'000},
    {"max_stiffness_mn_per_mm", &DeviceProfile::max_stiffness_mn_per_mm, 1, 1'000'000},
    {"coupling_mn_per_mm", &DeviceProfile::coupling_mn_per_mm, 1, 1'000'000},
    {"damping_mn_s_per_m", &DeviceProfile::damping_mn_s_per_m, 0, 1'000'000'000},
    {"friction_mn", &DeviceProfile::friction_mn, 0, 100'000},
    {"mass_g", &DeviceProfile::mass_g, 1, 100'000},
    {"peak_force_mn", &DeviceProfile::peak_force_mn, 1, 100'000},
    {"continuous_force_mn", &DeviceProfile::continuous_force_mn, 1, 100'000},
    {"rate_hz", &DeviceProfile::rate_hz, 100, 20'000},
    {"bus_delay_ticks", &DeviceProfile::bus_delay_ticks, 0, 100},
    {"workspace_radius_um", &DeviceProfile::workspace_radius_um, 1'000, 1'000'000},
}};

constexpr std::array<Number, 3> kOptional = {{
    {"axes", &DeviceProfile::axes, 3, 6},
    {"structural_mode_hz", &DeviceProfile::structural_mode_hz, 1, 10'000},
    {"thermal_time_constant_ms", &DeviceProfile::thermal_time_constant_ms, 1, 86'400'000},
}};

Sourced ReadSourced(ObjectReader& in, const Number& n, bool* measured = nullptr) {
  ObjectReader item = in.Object(n.name);
  Sourced s;
  s.value = item.Int("value", n.lo, n.hi);
  s.source = item.Text("source", 1, 500);
  if (measured != nullptr && item.Has(kMeasured)) {
    *measured = item.Bool(kMeasured);
    if (!*measured) item.Refuse(kMeasured, "true, or nothing", "false");
  }
  item.Finish();
  return s;
}

}  // namespace

std::string ToJson(const DeviceProfile& profile) {
  auto Known = [&](const Number& n) { return !(profile.*n.member).source.empty(); };
  bool optional = std::any_of(kOptional.begin(), kOptional.end(), Known);
  json::object out{{"format", profile.delay_measured ? kFormatMeasured
                              : optional             ? kFormatOptional
                                                     : kFormat},
                   {"name", profile.name},
                   {"title", profile.title}};
  for (const Number& n : kNumbers) {
    const Sourced& s = profile.*n.member;
    json::object item{{"value", s.value}, {"source", s.source}};
    if (profile.delay_measured && n.name == kDelay) item[kMeasured] = true;
    out[n.name] = std::move(item);
  }
  for (const Number& n : kOptional) {
    const Sourced& s = profile.*n.member;
    if (Known(n)) out[n.name] = json::object{{"value", s.value}, {"source", s.source}};
  }
  return CanonicalText(out);
}

Result<DeviceProfile> ProfileFromJson(std::string_view text) {
  Result<json::value> document = ParseBounded(text);
  if (!document.ok()) return document.status();
  Status status;
  ObjectReader in(*document, "", status);
  DeviceProfile profile;
  int64_t format = in.Format(kFormat, kFormatMeasured);
  profile.name = in.Name("name");
  profile.title = in.Text("title", 1, 200);
  for (const Number& n : kNumbers) {
    bool can_say = format >= kFormatMeasured && n.name == kDelay;
    profile.*n.member = ReadSourced(in, n, can_say ? &profile.delay_measured : nullptr);
  }
  for (const Number& n : kOptional) {
    if (format >= kFormatOptional && in.Has(n.name)) profile.*n.member = ReadSourced(in, n);
  }
  in.Finish();
  if (!status.ok()) return status;
  return profile;
}

}  // namespace enamel::scene
