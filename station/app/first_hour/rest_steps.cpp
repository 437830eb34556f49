// What the unit does when nobody touches it: noise at rest, the cable pulled, the end.
#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <chrono>
#include <cmath>
#include <optional>
#include <vector>

#include "station/app/first_hour/hour.h"
#include "station/devices/polled_device.h"

namespace enamel::station::first_hour {
namespace {

namespace json = boost::json;

constexpr double kRest_s = 2;
constexpr double kPull_s = 60, kPlugged_s = 30;
// From its last pose on, after which PolledDevice has found a silent device away.
constexpr double kSilent_s = std::chrono::duration<double>(PolledDevice::kSilentFor).count() + 0.5;

// One axis at rest, in counts: standard deviation about a straight line, how far that line goes, and the
// smallest step.
struct AtRest {
  double deviation = 0, drift = 0;
  int64_t least_step = 0, values = 0;
};

AtRest Rest(std::vector<int32_t> counts) {
  AtRest out;
  const auto n = static_cast<double>(counts.size());
  double sum = 0, times = 0;
  const double middle = 0.5 * (n - 1);
  for (size_t i = 0; i < counts.size(); ++i) {
    sum += counts[i];
    times += (static_cast<double>(i) - middle) * counts[i];
  }
  const double mean = sum / n, slope = n > 1 ? times / (n * (n * n - 1) / 12) : 0;
  double square = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    const double off = counts[i] - mean - slope * (static_cast<double>(i) - middle);
    square += off * off;
  }
  out.deviation = std::sqrt(square / n);
  out.drift = slope * n;
  std::ranges::sort(counts);
  for (size_t i = 1; i < counts.size(); ++i) {
    const int64_t step = int64_t{counts[i]} - counts[i - 1];
    if (step == 0) continue;
    ++out.values;
    if (out.least_step == 0 || step < out.least_step) out.least_step = step;
  }
  ++out.values;
  return out;
}

// Awaits a pose after the unit was plugged in again.
bool IsBack(const Rig& rig) { return rig.sample().attached && rig.sample().fresh; }

}  // namespace

Status Noise(Hour& hour, Step& step) {
  ENAMEL_RETURN_IF_ERROR(
      hour.Ask(step, "noise.still",
               "Lay the handle down so that nothing moves it, take your hands off the "
               "table, and press Enter.\nIt is listened to for two seconds.")
          .status());
  ENAMEL_RETURN_IF_ERROR(hour.Wait(0.5));
  std::array<std::vector<int32_t>, 3> counts;
  int ticks = 0;
  ENAMEL_RETURN_IF_ERROR(hour.Wait(kRest_s, [&] {
    ++ticks;
    if (!hour.rig().sample().fresh) return;
    for (size_t i = 0; i < 3; ++i) counts[i].push_back(hour.rig().sample().counts[i]);
  }));
  ENAMEL_RETURN_IF_ERROR(hour.UnitIsThere());
  if (counts[0].empty()) return Status(Code::kUnavailable, "no pose came meanwhile");
  const MeasuredDevice& unit = hour.rig().unit();
  const double cell_m = static_cast<double>(unit.profile.resolution_nm.value) * 1e-9;
  dvec3 deviation(0), drift(0), least(0);
  json::array values;
  for (int i = 0; i < 3; ++i) {
    const auto a = static_cast<size_t>(i);
    const AtRest rest = Rest(counts[a]);
    deviation[i] = rest.deviation * unit.count_m[a];
    drift[i] = rest.drift * unit.count_m[a];
    least[i] = static_cast<double>(rest.least_step) * unit.count_m[a];
    values.push_back(rest.values);
  }
  const dvec3 count(unit.count_m[0], unit.count_m[1], unit.count_m[2]);
  step.found = {{"fresh_share", Rounded(static_cast<double>(counts[0].size()) / ticks, 3)},
                {"deviation_counts", Rounded(deviation / count, 2)},
                {"deviation_um", Rounded(deviation * 1e6, 2)},
                {"drift_um", Rounded(drift * 1e6, 1)},
                {"smallest_step_um", Rounded(least * 1e6, 2)},
                {"values", values},
                {"profile_cell_um", Rounded(cell_m * 1e6, 2)}};
  for (int i = 0; i < 3; ++i) {
    const std::string axis = std::string("along ") + static_cast<char>('x' + i);
    const auto um = [](double m) { return std::to_string(std::lround(m * 1e6)) + " um"; };
    // From here on a reading at rest is off by a count now and then (CalibratorSetup, noise).
    if (deviation[i] > 0.5 * cell_m) {
      step.Problem("noise", axis + " a handle at rest varies by " + um(deviation[i]) +
                                " (standard deviation), and a cell has " + um(cell_m));
    }
    if (std::fabs(drift[i]) > 5 * cell_m)
      step.Problem("drift", axis + " a handle at rest drifts by " + um(drift[i]) + " in 2 s");
    if (least[i] > 2 * cell_m) {
      step.Problem("coarse", axis + " the smallest step is " + um(least[i]) +
                                 ", and a cell of its profile has " + um(cell_m));
    }
  }
  return Status::Ok();
}

Status Unplug(Hour& hour, Step& step) {
  Rig& rig = hour.rig();
  ENAMEL_RETURN_IF_ERROR(hour.Ask(step, "unplug.pull",
                                  "No force is on. Press Enter, and then pull the unit's cable out "
                                  "of the computer, within\n"
                                  "a minute.")
                             .status());
  ENAMEL_RETURN_IF_ERROR(hour.UnitIsThere());
  step.found["before"] = CountersOf(*rig.unit().device);
  const double from_s = rig.now_s();
  while (rig.sample().attached && rig.silent_s() < kSilent_s && rig.now_s() - from_s < kPull_s)
    ENAMEL_RETURN_IF_ERROR(hour.Wait(rig.tick_s()));
  const bool noticed = !rig.sample().attached;
  step.found["noticed"] = noticed;
  step.found["noticed_ms"] = Rounded(rig.silent_s() * 1e3, 1);
  step.found["after"] = CountersOf(*rig.unit().device);
  if (!noticed && rig.silent_s() < kSilent_s)
    return Status(Code::kUnavailable, "a minute passed and it was still there");
  if (!noticed) {
    step.Problem("unplug",
                 "for one and a half seconds after its last pose it was not reported as unplugged");
  }
  std::optional<double> back_s;
  const auto look = [&] {
    if (!back_s && IsBack(rig)) back_s = rig.now_s();
  };
  ENAMEL_RETURN_IF_ERROR(hour.Ask(step, "unplug.plugged",
                                  "The unit is gone. Plug it in again. If it has to be calibrated "
                                  "after that, do it now.\n"
                                  "Then press Enter.",
                                  look)
                             .status());
  const double asked_s = rig.now_s();
  while (!back_s && rig.now_s() - asked_s < kPlugged_s)
    ENAMEL_RETURN_IF_ERROR(hour.Wait(0.05, look));
  step.found["returned"] = back_s.has_value();
  step.found["returned_s"] = Rounded(back_s ? std::max(0.0, *back_s - asked_s) : 0, 2);
  step.found["reopened"] = json::array();
  if (back_s) return Status::Ok();
  step.Problem("no_return", "30 s after it was plugged in it had not come back by itself");
  hour.Tell("It did not come back by itself, so it is opened anew.");
  json::object attempt;
  const Status opened = hour.OpenUnit(attempt);
  step.found["reopened"].as_array().push_back(std::move(attempt));
  if (!opened.ok()) {
    step.Problem("open", "it did not open again: " + opened.message());
    return opened;
  }
  return hour.Wait(0.2);
}

Status End(Hour& hour, Step& step) {
  Rig& rig = hour.rig();
  ENAMEL_RETURN_IF_ERROR(hour.Wait(0.2));
  std::string question = "The last force was 0. Move the handle: is it free? yes or no.";
  std::string answer;
  while (rig.has_unit() && answer != "yes" && answer != "no") {
    ENAMEL_ASSIGN_OR_RETURN(answer, hour.Ask(step, "end.free", question));
    question = "yes or no?";
  }
  step.found["free"] = answer == "yes";
  if (answer == "no") step.Problem("force_left", "after force 0 the handle is not free");
  if (rig.has_unit()) step.found["counters"] = CountersOf(*rig.unit().device);
  const int64_t from_ns = Now_ns();
  rig.Close();
  step.found["close_ms"] = Rounded(static_cast<double>(Now_ns() - from_ns) * 1e-6, 1);
  return Status::Ok();
}

}  // namespace enamel::station::first_hour
