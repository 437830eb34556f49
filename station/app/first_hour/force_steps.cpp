// What the motors show: the direction of a push, its scale by a known weight, and the figures that
// 'calibrate' measures. Nothing here pushes before the person has typed yes.
#include <algorithm>
#include <boost/json.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>

#include "station/app/first_hour/hour.h"
#include "station/session/device_delay.h"

namespace enamel::station::first_hour {
namespace {

namespace json = boost::json;

// As robots that people guide by hand move at most, ISO 10218-1: reduced speed.
constexpr double kFastest_m_per_s = 0.25;
// Nobody holds the unit while it is calibrated, and its pushes of 1.5 mm reach 0.3 m/s on a light arm.
constexpr double kFastestAlone_m_per_s = 1.0;
constexpr double kFarthestPush_m = 0.03, kFarthestAlone_m = 0.1;

constexpr double kFirstPush_n = 0.5, kPushRise_n_per_s = 0.5, kPushHeld_s = 0.7;
constexpr double kMoved_m = 2e-3, kBegan_m = 1e-3;

// Slow, so that the handle is at rest until friction gives way: in the 0.3 s until 3 mm have been gone the
// force rises by 0.05 N. The way up and the way down are late by the same, so their mean is not.
constexpr double kLiftRise_n_per_s = 0.15, kLifted_m = 3e-3;
constexpr int kLifts = 2;
constexpr int kLeast_g = 20;                   // a gram of kitchen scales is 5 % of it
constexpr double kGravity_m_per_s2 = 9.80665;  // standard gravity, ISO 80000-3
constexpr double kScaleOff = 0.1;
// As a calibration is off at most, on simulated devices of all kinds (station/README.md).
constexpr double kDelayOff_ticks = 0.9;

std::string N(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f N", v);
  return text;
}

struct Push {
  dvec3 moved_m{0};
  double began_n = 0;  // when the handle had gone 1 mm
  std::string cut;
};

// Up to `most_n` along an axis, and down again.
Result<Push> PushAlong(Hour& hour, const dvec3& along, double most_n) {
  Rig& rig = hour.rig();
  ENAMEL_ASSIGN_OR_RETURN(const dvec3 from, hour.Place());
  Push out;
  rig.BeginPush({most_n, kFastest_m_per_s, kFarthestPush_m});
  const double rise_s = most_n / kPushRise_n_per_s, from_s = rig.now_s();
  while (rig.cut().empty() && rig.now_s() - from_s < rise_s + kPushHeld_s) {
    const double force_n = std::min(most_n, (rig.now_s() - from_s) * kPushRise_n_per_s);
    rig.Tick(along * force_n);
    out.moved_m = rig.tip_m() - from;
    const double gone = std::sqrt(Dot(out.moved_m, out.moved_m));
    if (out.began_n == 0 && gone > kBegan_m) out.began_n = force_n;
    if (gone > 0.5 * kFarthestPush_m) break;  // seen well enough
  }
  out.cut = rig.cut();
  rig.EndPush();
  if (rig.is_stopped()) return hour.Wait(1);
  ENAMEL_RETURN_IF_ERROR(hour.Wait(0.2));
  return out;
}

// The forces at which the handle begins to rise and to fall.
struct Lift {
  double rises_n = 0, falls_n = 0;
  double middle_n() const { return 0.5 * (rises_n + falls_n); }
};

Result<Lift> LiftOnce(Hour& hour, double most_n) {
  Rig& rig = hour.rig();
  ENAMEL_ASSIGN_OR_RETURN(const dvec3 from, hour.Place());
  Lift out;
  double force_n = 0, highest_m = from.z;
  const double step_n = kLiftRise_n_per_s * rig.tick_s();
  rig.BeginPush({most_n, kFastest_m_per_s, kFarthestPush_m});
  while (rig.cut().empty() && rig.tip_m().z - from.z < kLifted_m && force_n < most_n)
    rig.Tick(dvec3(0, 0, force_n += step_n));
  out.rises_n = force_n;
  const bool rose = rig.tip_m().z - from.z >= kLifted_m;
  // Down from here until it falls as far; an arm that is balanced has to be pushed down.
  while (rose && rig.cut().empty() && highest_m - rig.tip_m().z < kLifted_m && force_n > -most_n) {
    rig.Tick(dvec3(0, 0, force_n -= step_n));
    highest_m = std::max(highest_m, rig.tip_m().z);
  }
  out.falls_n = force_n;
  const std::string cut = rig.cut();
  const bool fell = highest_m - rig.tip_m().z >= kLifted_m;
  rig.EndPush();
  if (rig.is_stopped()) return hour.Wait(1);
  ENAMEL_RETURN_IF_ERROR(hour.Wait(1));
  if (!cut.empty()) return Status(Code::kUnavailable, "the force was ended: " + cut);
  if (!rose) return Status(Code::kUnavailable, "the handle did not rise by 3 mm at " + N(most_n));
  if (!fell) return Status(Code::kUnavailable, "the handle did not fall again");
  return out;
}

// The mean of all lifts, with the half width of what they differ by.
struct Lifted {
  double middle_n = 0, off_n = 0, friction_n = 0;
};

Result<Lifted> LiftAgain(Hour& hour, double most_n, json::object& found) {
  json::array rises, falls;
  double low = 1e9, high = -1e9;
  Lifted out;
  for (int i = 0; i < kLifts; ++i) {
    ENAMEL_ASSIGN_OR_RETURN(const Lift lift, LiftOnce(hour, most_n));
    rises.push_back(Rounded(lift.rises_n, 3));
    falls.push_back(Rounded(lift.falls_n, 3));
    low = std::min(low, lift.middle_n());
    high = std::max(high, lift.middle_n());
    out.middle_n += lift.middle_n() / kLifts;
    out.friction_n += 0.5 * (lift.rises_n - lift.falls_n) / kLifts;
  }
  found = {{"rises_at_n", rises}, {"falls_at_n", falls}};
  out.off_n = 0.5 * (high - low);
  return out;
}

// Grams of a mass that the motors can lift beside the arm's own weight and friction.
Result<double> AskMass(Hour& hour, Step& step, double most_n) {
  const double most_g = std::floor(0.6 * most_n / kGravity_m_per_s2 * 100) * 10;
  if (most_g < kLeast_g)
    return Skipped(N(most_n) + " are too little for a mass of " + std::to_string(kLeast_g) + " g");
  std::string question =
      "Which mass can you hang on the handle with a thread, in grams? Weigh it: kitchen scales "
      "will\n"
      "do. " +
      std::to_string(kLeast_g) + " to " + std::to_string(std::lround(most_g)) +
      " g; type skip and a reason if you have none.";
  while (true) {
    ENAMEL_ASSIGN_OR_RETURN(const std::string answer, hour.Ask(step, "weight.grams", question));
    double grams = 0;
    const auto [end, error] = std::from_chars(answer.data(), answer.data() + answer.size(), grams);
    if (error == std::errc() && end == answer.data() + answer.size() && grams >= kLeast_g &&
        grams <= most_g)
      return grams;
    question = "A number from " + std::to_string(kLeast_g) + " to " +
               std::to_string(std::lround(most_g)) + ", found '" + answer + "'. How many grams?";
  }
}

json::object EstimateJson(const Estimate& e, double unit, int digits) {
  return {{"value", Rounded(e.value / unit, digits)},
          {"uncertainty", Rounded(e.uncertainty / unit, digits)},
          {"samples", e.samples}};
}

json::object FiguresJson(const AxisFigures& f) {
  return {{"delay_ticks", EstimateJson(f.delay_ticks, 1, 2)},
          {"noise_um", EstimateJson(f.noise_m, 1e-6, 3)},
          {"cell_um", EstimateJson(f.resolution_m, 1e-6, 3)},
          {"friction_n", EstimateJson(f.friction_n, 1, 4)},
          {"damping_n_s_per_m", EstimateJson(f.damping_n_s_per_m, 1, 3)},
          {"mass_g", EstimateJson(f.mass_kg, 1e-3, 1)},
          {"mode_hz", EstimateJson(f.mode_hz, 1, 1)}};
}

// As the figures of 'calibrate' say it, and as attempts would be computed.
void NoteTimes(Hour& hour, Step& step) {
  const Device& device = *hour.rig().unit().device;
  step.found["answers"] = nullptr;
  if (const auto answers = device.answer_time()) {
    step.found["answers"] = json::object{{"median_us", answers->median_us},
                                         {"p99_us", answers->p99_us},
                                         {"answers", answers->answers}};
  }
  step.found["poses"] = nullptr;
  if (!hour.setup().by_clock) return;
  if (const auto poses = AwaitPosePeriod(device)) {
    step.found["poses"] = json::object{
        {"median_us", poses->median_us}, {"p99_us", poses->p99_us}, {"poses", poses->poses}};
  }
}

}  // namespace

Status Force(Hour& hour, Step& step) {
  struct Axis {
    const char *id, *says;
    dvec3 along;
  };
  const Axis axes[] = {{"x", "+x, to your right", dvec3(1, 0, 0)},
                       {"y", "+y, away from you", dvec3(0, 1, 0)},
                       {"z", "+z, up", dvec3(0, 0, 1)}};
  hour.Tell(
      "From here on the motors push, each time only after you have typed yes. The force ends when "
      "the\n"
      "handle is faster than 0.25 m/s or farther than 3 cm. Keep your face away from the handle.");
  for (const Axis& axis : axes) {
    double most_n = std::min(kFirstPush_n, hour.MostForce_n());
    Push push;
    while (true) {
      ENAMEL_RETURN_IF_ERROR(
          hour.AskToPush(step, std::string("force.") + axis.id + ".yes",
                         std::string("The next push is along ") + axis.says +
                             ". Hold the handle loosely in the middle, with two fingers.",
                         most_n));
      ENAMEL_ASSIGN_OR_RETURN(push, PushAlong(hour, axis.along, most_n));
      const bool moved = Dot(push.moved_m, push.moved_m) > kMoved_m * kMoved_m;
      if (moved || !push.cut.empty() || most_n >= hour.MostForce_n()) break;
      hour.Tell("It moved by less than 2 mm.");
      most_n = std::min(2 * most_n, hour.MostForce_n());
    }
    const bool moved = Dot(push.moved_m, push.moved_m) > kMoved_m * kMoved_m;
    const std::string found = moved ? AxisOf(push.moved_m, 0.5) : "";
    const std::string expected = std::string("+") + axis.id;
    step.found[axis.id] = json::object{{"force_n", Rounded(most_n, 2)},
                                       {"moved_mm", Rounded(push.moved_m * 1e3, 1)},
                                       {"axis", found},
                                       {"with_the_force", found == expected},
                                       {"began_at_n", Rounded(push.began_n, 2)},
                                       {"ended_by", push.cut}};
    if (!moved) {
      step.Problem("force_none", N(most_n) + " along " + expected + " did not move the handle");
    } else if (found != expected) {
      step.Problem("force_direction", "a force along " + expected + " moved the handle along " +
                                          (found.empty() ? "no axis" : found));
    }
    if (!push.cut.empty()) step.Problem("force_ended", "along " + expected + ": " + push.cut);
  }
  return Status::Ok();
}

Status Weight(Hour& hour, Step& step) {
  const double most_n = hour.MostForce_n();
  ENAMEL_ASSIGN_OR_RETURN(const double grams, AskMass(hour, step, most_n));
  const double weight_n = grams * 1e-3 * kGravity_m_per_s2;
  step.found["grams"] = grams;
  step.found["expected_n"] = Rounded(weight_n, 3);
  const std::string how =
      "The motors lift the handle by a few millimetres and let it down, twice, slowly. Hands off, "
      "and\n"
      "nothing of the unit that the handle could hit.";
  ENAMEL_RETURN_IF_ERROR(hour.AskToPush(
      step, "weight.empty.yes",
      "First without the mass. Lay the handle down in the middle of its reach, on a\n"
      "stack of books, so that it can rise freely.\n" +
          how,
      most_n));
  json::object found;
  ENAMEL_ASSIGN_OR_RETURN(const Lifted empty, LiftAgain(hour, most_n, found));
  step.found["empty"] = found;
  ENAMEL_RETURN_IF_ERROR(hour.AskToPush(step, "weight.loaded.yes",
                                        "Now hang the mass on the handle, where the hand holds it; "
                                        "it must hang freely, and the handle\n"
                                        "must lie where it lay.\n" +
                                            how,
                                        most_n));
  ENAMEL_ASSIGN_OR_RETURN(const Lifted loaded, LiftAgain(hour, most_n, found));
  step.found["loaded"] = found;
  // What is asked for is larger than what arrives, by the scale: k (loaded - empty) = m g.
  const double asked_n = loaded.middle_n - empty.middle_n;
  if (!(asked_n > 0.1 * weight_n)) {
    return Status(Code::kUnavailable, "with the mass it took " + N(asked_n) +
                                          " more than without, and it weighs " + N(weight_n));
  }
  const double scale = weight_n / asked_n;
  step.found["up"] = json::object{
      {"scale_percent", Rounded(100 * scale, 1)},
      {"uncertainty_percent", Rounded(100 * scale * (loaded.off_n + empty.off_n) / asked_n, 1)}};
  step.found["own_weight_n"] = Rounded(scale * empty.middle_n, 3);
  step.found["friction_n"] = Rounded(scale * empty.friction_n, 3);
  hour.Tell("Up, " + std::to_string(std::lround(100 * scale)) + " % of a force arrives.");
  if (std::fabs(scale - 1) > kScaleOff) {
    step.Problem("force_scale", "up, " + std::to_string(std::lround(100 * scale)) +
                                    " % of the force that was asked for arrives");
  }
  return Status::Ok();
}

Status Delay(Hour& hour, Step& step) {
  const MeasuredDevice& unit = hour.rig().unit();
  CalibratorSetup setup;
  setup.count_m = unit.count_m;
  setup.tick_s = hour.setup().tick_s;
  setup.max_force_n = hour.MostForce_n();
  ENAMEL_RETURN_IF_ERROR(
      hour.AskToPush(step, "delay.yes",
                     "Now the unit moves by itself for a minute and a half, about a centimetre "
                     "each way. Take the\n"
                     "mass off. Put the arm in the middle of its reach, balanced or on a rest that "
                     "lets it move, and\n"
                     "take all hands off. This measures what 'enamel-station calibrate' measures.",
                     setup.max_force_n));
  Calibrator calibrator(setup);
  std::string doing;
  Rig& rig = hour.rig();
  rig.BeginPush({setup.max_force_n, kFastestAlone_m_per_s, kFarthestAlone_m});
  while (!calibrator.done() && rig.cut().empty()) {
    rig.TickWith([&](const DeviceSample& sample) { return calibrator.Step(sample); });
    if (calibrator.Doing() == doing || calibrator.done()) continue;
    doing = calibrator.Doing();
    hour.Tell("  " + doing);
  }
  const std::string cut = rig.cut();
  rig.EndPush();
  NoteTimes(hour, step);
  if (rig.is_stopped()) return hour.Wait(1);
  if (!cut.empty()) return Status(Code::kUnavailable, "the force was ended: " + cut);
  ENAMEL_ASSIGN_OR_RETURN(const auto figures, calibrator.Figures());
  json::array axes;
  int64_t ticks = 0;
  double surely = 0;
  for (const AxisFigures& axis : figures) {
    axes.push_back(FiguresJson(axis));
    ticks = std::max(ticks, WholeTicks(axis.delay_ticks));
    surely = std::max(surely, axis.delay_ticks.value - axis.delay_ticks.uncertainty);
  }
  step.found["axes"] = axes;
  step.found["whole_ticks"] = ticks;
  const int64_t said = unit.profile.bus_delay_ticks.value;
  step.found["profile_ticks"] = said;
  if (surely > static_cast<double>(said) + kDelayOff_ticks) {
    step.Problem("delay", "a force acts after " + std::to_string(ticks) +
                              " ms, and its profile says " + std::to_string(said));
  }
  return Status::Ok();
}

}  // namespace enamel::station::first_hour
