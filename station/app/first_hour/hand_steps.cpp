// What the person's hand shows: that the unit opens, knows where it is, how far it reaches, which way
// its axes point, and its buttons.
#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <limits>

#include "station/app/first_hour/hour.h"

namespace enamel::station::first_hour {
namespace {

namespace json = boost::json;

constexpr double kFirstPose_s = 5, kButtons_s = 120;
// A hand makes 2 m/s at most; between two poses of 1 kHz that is 2 mm.
constexpr double kJump_m = 5e-3;
constexpr double kStraightWay_m = 0.05, kMinWay_m = 0.02;
constexpr int kTries = 3;

// Follows the newest pose tick by tick.
class Follower {
 public:
  explicit Follower(Rig& rig) : rig_(rig) {}
  void Look() {
    if (!rig_.sample().fresh) return;
    ++poses_;
    const dvec3 at = rig_.tip_m();
    if (poses_ > 1) {
      const dvec3 way = at - last_;
      jump_m_ = std::max(jump_m_, std::sqrt(Dot(way, way)));
    }
    last_ = at;
    low_ = glm::min(low_, at);
    high_ = glm::max(high_, at);
    fastest_ = std::max(fastest_, rig_.speed_m_per_s());
  }
  int poses() const { return poses_; }
  double jump_m() const { return jump_m_; }
  double fastest_m_per_s() const { return fastest_; }
  const dvec3& low() const { return low_; }
  const dvec3& high() const { return high_; }

 private:
  Rig& rig_;
  int poses_ = 0;
  double jump_m_ = 0, fastest_ = 0;
  dvec3 last_{0}, low_{std::numeric_limits<double>::infinity()},
      high_{-std::numeric_limits<double>::infinity()};
};

std::string Mm(double m) { return std::to_string(std::lround(m * 1e3)) + " mm"; }

struct Way {
  const char *id, *says, *axis;
};
constexpr Way kWays[] = {
    {"right", "to your right", "+x"}, {"away", "away from you", "+y"}, {"up", "straight up", "+z"}};

// One of the three ways: where the handle went, m.
Result<dvec3> AskWay(Hour& hour, Step& step, const Way& way) {
  const std::string id = std::string("directions.") + way.id;
  for (int i = 0; i < kTries; ++i) {
    ENAMEL_RETURN_IF_ERROR(
        hour.Ask(step, id + ".from", "Hold the handle still, near the middle. Then press Enter.")
            .status());
    ENAMEL_ASSIGN_OR_RETURN(const dvec3 from, hour.Place());
    ENAMEL_RETURN_IF_ERROR(hour.Ask(step, id + ".to",
                                    std::string("Move it ") + way.says +
                                        " by about 5 cm, hold it still, and press Enter.")
                               .status());
    ENAMEL_ASSIGN_OR_RETURN(const dvec3 to, hour.Place());
    const dvec3 moved = to - from;
    if (std::sqrt(Dot(moved, moved)) >= kMinWay_m) return moved;
    hour.Tell("That was " + Mm(std::sqrt(Dot(moved, moved))) + ". Once more, about 5 cm:");
  }
  return Status(Code::kUnavailable, "the handle was moved " + std::string(way.says) +
                                        " three times, and its place " + "changed by less than " +
                                        Mm(kMinWay_m));
}

}  // namespace

Status Start(Hour& hour, Step& step) {
  hour.Tell(
      "Connect the unit as the guide says (docs/haptic_devices.md, \"First hour with a real "
      "unit\").\n"
      "Nothing is pushed in this step. Each question waits for half an hour. Instead of an answer "
      "you\n"
      "may type skip and a reason. Ctrl-C ends the hour at any time, and keeps what was found.");
  step.found["attempts"] = json::array();
  double opened_ms = 0;
  while (true) {
    ENAMEL_RETURN_IF_ERROR(
        hour.Ask(step, "start.open", "Is it connected and switched on? Press Enter to open it.")
            .status());
    json::object attempt;
    const Status opened = hour.OpenUnit(attempt);
    opened_ms = attempt.at("took_ms").to_number<double>();
    step.found["attempts"].as_array().push_back(std::move(attempt));
    if (opened.ok()) break;
    step.Problem("open", "it did not open: " + opened.message());
    hour.Tell("It did not open: " + opened.message() + ".\nDo that, and try again:");
  }
  // The driver may have had a pose before it returned: then the first tick has it.
  const double from_s = hour.rig().now_s();
  while (!hour.rig().sample().fresh && hour.rig().now_s() - from_s < kFirstPose_s)
    ENAMEL_RETURN_IF_ERROR(hour.Wait(hour.rig().tick_s()));
  if (!hour.rig().sample().fresh)
    return Status(Code::kUnavailable, "it opened, and sent no pose within 5 s");
  step.found["first_pose_ms"] = Rounded(opened_ms + (hour.rig().now_s() - from_s) * 1e3, 1);
  hour.Tell("Open: " + hour.rig().unit().device->Name() + ", profile " +
            hour.rig().unit().profile.name + ".");
  return Status::Ok();
}

Status Homing(Hour& hour, Step& step) {
  ENAMEL_ASSIGN_OR_RETURN(
      const std::string did,
      hour.Ask(
          step, "homing.did",
          "What did you do so that the unit knows where its handle is (pit, inkwell, home pose,\n"
          "in and out, …)? One line; just Enter for nothing."));
  step.found["did"] = did;
  ENAMEL_RETURN_IF_ERROR(
      hour.Ask(step, "homing.middle",
               "Hold the handle still in the middle of its reach. Then press Enter.")
          .status());
  Follower follower(hour.rig());
  int ticks = 0;
  ENAMEL_RETURN_IF_ERROR(hour.Wait(1, [&] {
    follower.Look();
    ++ticks;
  }));
  ENAMEL_RETURN_IF_ERROR(hour.UnitIsThere());
  const dvec3 at = hour.rig().tip_m();
  const double radius_m =
      static_cast<double>(hour.rig().unit().profile.workspace_radius_um.value) * 1e-6;
  const double off_m = std::sqrt(Dot(at, at));
  step.found["in_middle_mm"] = Rounded(at * 1e3, 1);
  step.found["largest_jump_mm"] = Rounded(follower.jump_m() * 1e3, 2);
  step.found["fresh_share"] =
      Rounded(static_cast<double>(follower.poses()) / std::max(ticks, 1), 3);
  const bool plausible = off_m <= radius_m && follower.jump_m() < kJump_m && follower.poses() > 1;
  step.found["plausible"] = plausible;
  if (off_m > radius_m) {
    step.Problem("pose", "in the middle of its reach the handle is reported " + Mm(off_m) +
                             " from where it was opened, and its profile reaches " + Mm(radius_m));
  }
  if (follower.jump_m() >= kJump_m)
    step.Problem("pose", "held still, the pose jumped by " + Mm(follower.jump_m()));
  if (follower.poses() <= 1) step.Problem("pose", "held still, it sent no new pose for a second");
  return Status::Ok();
}

Status Workspace(Hour& hour, Step& step) {
  Follower follower(hour.rig());
  ENAMEL_RETURN_IF_ERROR(
      hour.Ask(step, "workspace.end",
               "Move the handle slowly to all its ends: left and right, toward you and\n"
               "away, down and up, and once around. Then press Enter.",
               [&] { follower.Look(); })
          .status());
  ENAMEL_RETURN_IF_ERROR(hour.UnitIsThere());
  if (follower.poses() == 0) return Status(Code::kUnavailable, "no pose came meanwhile");
  const double radius_m =
      static_cast<double>(hour.rig().unit().profile.workspace_radius_um.value) * 1e-6;
  const dvec3 extent = follower.high() - follower.low();
  step.found = {{"from_mm", Rounded(follower.low() * 1e3, 1)},
                {"to_mm", Rounded(follower.high() * 1e3, 1)},
                {"extent_mm", Rounded(extent * 1e3, 1)},
                {"profile_radius_mm", Rounded(radius_m * 1e3, 1)},
                {"share_of_profile", Rounded(extent / (2 * radius_m), 2)},
                {"largest_jump_mm", Rounded(follower.jump_m() * 1e3, 2)},
                {"fastest_mm_per_s", Rounded(follower.fastest_m_per_s() * 1e3, 0)},
                {"poses", follower.poses()}};
  for (int i = 0; i < 3; ++i) {
    const double share = extent[i] / (2 * radius_m);
    const std::string reach = std::string("along ") + static_cast<char>('x' + i) + " it reaches " +
                              Mm(extent[i]) + ", and its profile " + Mm(2 * radius_m);
    // Profiles have one radius for reaches that differ by axis. Metres taken for millimetres are far off.
    if (share < 0.5) step.Problem("workspace_small", reach);
    if (share > 2.5) step.Problem("workspace_large", reach);
  }
  if (follower.jump_m() >= kJump_m)
    step.Problem("pose", "on its way the pose jumped by " + Mm(follower.jump_m()));
  return Status::Ok();
}

Status Directions(Hour& hour, Step& step) {
  hour.Tell("Sit in front of the unit as at the chair. Nothing is pushed in this step.");
  dmat3 moved(0);
  std::string found;
  bool as_expected = true;
  double length_m = 0;
  for (int i = 0; i < 3; ++i) {
    const Way& way = kWays[i];
    ENAMEL_ASSIGN_OR_RETURN(moved[i], AskWay(hour, step, way));
    const double length = std::sqrt(Dot(moved[i], moved[i]));
    const std::string axis = AxisOf(moved[i]);
    step.found[way.id] = json::object{
        {"moved_mm", Rounded(moved[i] * 1e3, 1)}, {"axis", axis}, {"expected", way.axis}};
    found += (i > 0 ? ", " : "") + std::string(way.id) + " comes as " +
             (axis.empty() ? "none of the axes" : axis);
    as_expected = as_expected && axis == way.axis;
    moved[i] /= length;
    length_m += length / 3;
  }
  const double turn = glm::determinant(moved);
  step.found["as_expected"] = as_expected;
  step.found["right_handed"] = turn > 0;
  step.found["length_share"] = Rounded(length_m / kStraightWay_m, 2);
  if (!as_expected) {
    step.Problem("axes", found + "; expected +x, +y, +z" +
                             (turn > 0 ? ""
                                       : ". They are mirrored: one sign is wrong, or two axes "
                                         "are exchanged"));
  }
  // A hand's 5 cm is 3 to 8.
  if (length_m < 0.5 * kStraightWay_m || length_m > 2 * kStraightWay_m)
    step.Problem("length", "moves of about 5 cm come as " + Mm(length_m));
  return Status::Ok();
}

Status Buttons(Hour& hour, Step& step) {
  struct Bit {
    const char* name;
    uint8_t bit;
    int presses = 0;
  };
  Bit bits[] = {{"pedal", kPedal}, {"second", kSecond}, {"put_down", kPutDown}};
  ENAMEL_RETURN_IF_ERROR(hour.Wait(0.1));
  uint8_t before = hour.rig().sample().buttons;
  const uint8_t at_first = before;
  const double from_s = hour.rig().now_s();
  ENAMEL_RETURN_IF_ERROR(
      hour.Ask(step, "buttons.end",
               "Press and release each button of the handle, and the pedal if there is one, once.\n"
               "Two minutes are listened to. Then press Enter.",
               [&] {
                 if (hour.rig().now_s() - from_s > kButtons_s) return;
                 const uint8_t now = hour.rig().sample().buttons;
                 for (Bit& b : bits) b.presses += (now & b.bit) != 0 && (before & b.bit) == 0;
                 before = now;
               })
          .status());
  ENAMEL_RETURN_IF_ERROR(hour.UnitIsThere());
  bool any = false;
  for (const Bit& b : bits) {
    step.found[b.name] = json::object{{"presses", b.presses},
                                      {"down_before", (at_first & b.bit) != 0},
                                      {"down_after", (before & b.bit) != 0}};
    any = any || b.presses > 0;
    if ((before & b.bit) != 0 && (at_first & b.bit) == 0)
      step.Problem("button", std::string("the button '") + b.name + "' stayed down");
  }
  if (!any) step.Problem("button", "no button was seen");
  return Status::Ok();
}

}  // namespace enamel::station::first_hour
