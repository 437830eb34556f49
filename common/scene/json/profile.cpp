#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <string>

#include "common/core/params.h"
#include "common/scene/json/json.h"
#include "common/scene/json/kinds.h"
#include "common/scene/json/read.h"
#include "common/scene/json/text.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

constexpr std::string_view kDelay = "bus_delay_ticks", kFriction = "friction_mn",
                           kMeasured = "measured", kTorque = "torque", kCell = "cell",
                           kBoardSpring = "board_spring";
constexpr int64_t kSixAxes = 6;

template <typename Owner>
struct NumberOf {
  const char* name;
  Sourced Owner::*member;
  int64_t lo, hi;
};
using Number = NumberOf<DeviceProfile>;

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

constexpr Number kElectrical = {"electrical_damping_mn_s_per_m",
                                &DeviceProfile::electrical_damping_mn_s_per_m, 1, 1'000'000'000};

constexpr std::array<NumberOf<TorqueSpec>, 5> kTorqueNumbers = {{
    {"peak_un_m", &TorqueSpec::peak_un_m, 1, 100'000'000},
    {"coupling_un_m_per_rad", &TorqueSpec::coupling_un_m_per_rad, 1, 100'000'000},
    {"damping_un_m_s_per_rad", &TorqueSpec::damping_un_m_s_per_rad, 0, 1'000'000'000},
    {"friction_un_m", &TorqueSpec::friction_un_m, 0, 100'000'000},
    {"orientation_cell_urad", &TorqueSpec::orientation_cell_urad, core::kMinRotationCell_urad,
     100'000},
}};

// The flag that says that a number was measured on a unit; nullptr for a number that has no such flag.
template <typename Profile>
auto MeasuredFlag(Profile& profile, const Number& n) -> decltype(&profile.delay_measured) {
  if (n.name == kDelay) return &profile.delay_measured;
  return n.name == kFriction ? &profile.friction_measured : nullptr;
}

template <typename Owner>
Sourced ReadSourced(ObjectReader& in, const NumberOf<Owner>& n, bool* measured = nullptr) {
  ObjectReader item = in.Object(n.name);
  Sourced s;
  s.value = item.Int("value", n.lo, n.hi);
  s.source = item.Text("source", 1, 500);
  if (measured != nullptr && item.Has(kMeasured)) {
    *measured = item.Bool(kMeasured);
    // "No" is said by saying nothing: one meaning, one text, one address.
    if (!*measured) item.Refuse(kMeasured, "true, or nothing", "false");
  }
  item.Finish();
  return s;
}

json::object Document(const Sourced& s) { return {{"value", s.value}, {"source", s.source}}; }

json::object Document(const CellSpec& cell) {
  return {{"lattice", cell.joints ? "joints" : "axes"},
          {"count_nm", cell.count_nm},
          {"noise_counts", cell.noise_counts},
          {"source", cell.source}};
}

json::object Document(const BoardSpringSpec& spring) {
  return {
      {"rate_hz", spring.rate_hz}, {"delay_ticks", spring.delay_ticks}, {"source", spring.source}};
}

void ReadBoardSpring(ObjectReader& in, DeviceProfile& profile) {
  if (!in.Has(kBoardSpring)) return;
  ObjectReader item = in.Object(kBoardSpring);
  BoardSpringSpec& spring = profile.board_spring.emplace();
  // As in the board's feature report (schemas/hid_haptic_report.md).
  spring.rate_hz = static_cast<int32_t>(item.Int("rate_hz", 100, 65'535));
  spring.delay_ticks = static_cast<int32_t>(item.Int("delay_ticks", 0, 16));
  spring.source = item.Text("source", 1, 500);
  item.Finish();
}

void ReadCell(ObjectReader& in, DeviceProfile& profile) {
  if (!in.Has(kCell)) return;
  ObjectReader item = in.Object(kCell);
  CellSpec& cell = profile.cell.emplace();
  const std::string lattice = item.Text("lattice", 1, 16);
  cell.joints = lattice == "joints";
  if (!cell.joints && lattice != "axes")
    item.Refuse("lattice", "\"axes\" or \"joints\"", "\"" + lattice + "\"");
  cell.count_nm = static_cast<int32_t>(item.Int("count_nm", 1, profile.resolution_nm.value));
  cell.noise_counts = static_cast<int32_t>(item.Int("noise_counts", 0, 16));
  cell.source = item.Text("source", 1, 500);
  item.Finish();
}

void ReadTorque(ObjectReader& in, DeviceProfile& profile) {
  // Axes and torque must say the same, or a device would be driven by half a profile.
  const bool six = profile.axes.value == kSixAxes;
  if (!in.Has(kTorque)) {
    if (six)
      in.Refuse(
          kTorque,
          "its figures for the three axes of rotation, as axes is 6 (3: it drives no rotation)",
          "nothing");
    return;
  }
  if (!six) {
    in.Refuse(kTorque, "nothing, or axes 6",
              "torque with axes " + std::to_string(profile.axes.value));
    return;
  }
  ObjectReader item = in.Object(kTorque);
  TorqueSpec& torque = profile.torque.emplace();
  for (const auto& n : kTorqueNumbers) torque.*n.member = ReadSourced(item, n);
  item.Finish();
}

}  // namespace

std::vector<std::string> AskedFor(const DeviceProfile& profile) {
  std::vector<std::string> out;
  for (const Number& n : kNumbers) {
    if ((profile.*n.member).source.starts_with("asked for")) out.emplace_back(n.name);
  }
  return out;
}

std::string ToJson(const DeviceProfile& profile) {
  auto Known = [&](const Number& n) { return !(profile.*n.member).source.empty(); };
  json::object out{{kProfileKind, kFormat}, {"name", profile.name}, {"title", profile.title}};
  for (const Number& n : kNumbers) {
    const Sourced& s = profile.*n.member;
    json::object item = Document(s);
    const bool* measured = MeasuredFlag(profile, n);
    if (measured != nullptr && *measured) item[kMeasured] = true;
    out[n.name] = std::move(item);
  }
  if (profile.cell) out[kCell] = Document(*profile.cell);
  if (profile.board_spring) out[kBoardSpring] = Document(*profile.board_spring);
  for (const Number& n : kOptional) {
    // Known by its source: every number has one, and 0 may be a value.
    if (Known(n)) out[n.name] = Document(profile.*n.member);
  }
  // In the order of the canonical document, as above.
  if (Known(kElectrical)) out[kElectrical.name] = Document(profile.*kElectrical.member);
  if (profile.torque) {
    json::object item;
    for (const auto& n : kTorqueNumbers) item[n.name] = Document((*profile.torque).*n.member);
    out[kTorque] = std::move(item);
  }
  return CanonicalText(out);
}

Result<DeviceProfile> ProfileFromJson(std::string_view text) {
  ENAMEL_ASSIGN_OR_RETURN(json::value document, ParseBounded(text));
  Status status;
  ObjectReader in(document, "", status);
  DeviceProfile profile;
  in.Format(kProfileKind);
  profile.name = in.Name("name");
  profile.title = in.Text("title", 1, 200);
  for (const Number& n : kNumbers) {
    profile.*n.member = ReadSourced(in, n, MeasuredFlag(profile, n));
  }
  ReadCell(in, profile);
  ReadBoardSpring(in, profile);
  for (const Number& n : kOptional) {
    if (in.Has(n.name)) profile.*n.member = ReadSourced(in, n);
  }
  if (in.Has(kElectrical.name)) profile.*kElectrical.member = ReadSourced(in, kElectrical);
  ReadTorque(in, profile);
  in.Finish();
  ENAMEL_RETURN_IF_ERROR(status);
  return profile;
}

}  // namespace enamel::scene
