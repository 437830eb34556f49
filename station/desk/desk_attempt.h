#pragma once

#include <memory>
#include <optional>
#include <string>

#include "station/desk/depth_gauge.h"
#include "station/desk/device_offers.h"
#include "station/desk/held_device.h"
#include "station/desk/target_outline.h"
#include "station/desk/watch/nearness.h"
#include "station/desk/watch/reach_watch.h"
#include "station/desk/watch/tick_feed.h"
#include "station/desk/watch/zone_watch.h"
#include "station/devices/pointer_device.h"
#include "station/devices/simulated_device.h"
#include "station/render/window.h"
#include "station/session/unrecorded_run.h"
#include "station/session/workplace.h"

namespace enamel::station::desk {

// What the view of an exercise's tooth begins with: the bur, and the place to cut.
render::ViewOptions ViewOf(const scene::Scene& scene, const scene::Exercise& exercise);
// The same, with the device's largest force.
render::ViewOptions ViewOf(const PreparedAttempt& prepared);

// One attempt in the window: its documents, the device, the picture, and from Begin on the running
// attempt. Owner's thread only; the tick sees the device and the feed.
class DeskAttempt {
 public:
  // `attached` is the offer's HID device, opened; null if it has none. `mouth`: draw it where the
  // scene has a tooth. Errors: those of a simulated
  // hand, or of a driver that refuses the picture.
  static Result<std::unique_ptr<DeskAttempt>> Create(PreparedAttempt prepared,
                                                     const DeviceOffer& offer,
                                                     std::unique_ptr<Device> attached, bool mouth);
  ~DeskAttempt();

  const PreparedAttempt& prepared() const { return prepared_; }
  PreparedAttempt& prepared() { return prepared_; }
  Device& device() { return *held_; }
  HeldDevice& held() { return *held_; }
  render::ToothView& view() { return *view_; }
  bool by_pointer() const { return pointer_ != nullptr; }
  bool simulated() const { return simulated_ != nullptr; }
  // Its axes may be turned with the picture: held in a hand, and held_device.h allows it.
  bool turns_with_view() const;
  // Degrees by which it stands turned on its table (hand_turn.h).
  void StandsTurned(int turn_deg) { turn_deg_ = turn_deg; }
  int stands_turned_deg() const { return turn_deg_; }
  // Where the device says that the hand is, its own axes.
  dvec3 hand_m() const;
  std::optional<render::ZoneShares> zones() const { return zones_->shares(); }
  render::Reach reach() const { return reach_->reach(); }
  // What the turning bur is near to; nothing while it rests.
  Warned warned() const;
  // Writes beside the bur's tip: where it is under the uncut surface and `depth` is wanted, how deep
  // it is and how far from the target's floor; and the warning, if there is one.
  void WriteBesideBur(const language::Words& words, const render::Screen& screen, bool depth,
                      const Warned& warned) const;

  // Shows the target's outline on the tooth once it is computed.
  void ShowOutline(bool shown) { view_->ShowOutline(shown); }
  // Asks for the next of the exercise's burs, after the last the first again.
  void NextBur();
  // The tooth is meshed, and what is around it is there: nobody should cut what cannot be seen yet.
  bool drawn();

  // Starts with the first tick. The loop is bound to processor `cpu`; -1: to none.
  Status Begin(Workplace& workplace, int cpu);
  // Starts ticking with nothing recorded: to try the device (warm_up.h), or, once the attempt's
  // Join or the rehearsal's End has returned, to continue with the tooth as it was left.
  void Rehearse(int cpu);
  // Ends what runs, with force 0 and an attempt stored as far as it was recorded (RunningAttempt::Leave),
  // and closes the device. Draws nothing. Only the destructor may follow.
  void LeaveAtOnce();
  // Null before Begin.
  RunningAttempt* run() { return run_.get(); }
  // Null before Rehearse.
  UnrecordedRun* rehearsal() { return rehearsal_.get(); }
  // The newest tick of the one that began last; nothing before it.
  Snapshot newest();
  // Of the one that runs (RunningAttempt::lacks_realtime), for a device whose lateness matters.
  bool lacks_realtime() const;

  // Turns this frame's mouse and key input into the device's pose. `held`: ignore it (a dialog is
  // open).
  void Point(const render::Screen& screen, double dt_s, bool held);

 private:
  AttemptOptions OptionsFor(int cpu) const;
  explicit DeskAttempt(PreparedAttempt prepared) : prepared_(std::move(prepared)) {}

  PreparedAttempt prepared_;
  std::unique_ptr<Device> attached_;
  std::unique_ptr<SimulatedDevice> simulated_;
  std::unique_ptr<PointerDevice> pointer_;
  std::optional<PointerMapping> mapping_;  // none without a pointer
  std::unique_ptr<HeldDevice> held_;
  std::unique_ptr<ZoneWatch> zones_;
  std::unique_ptr<ReachWatch> reach_;
  std::unique_ptr<NearnessWatch> nearness_;
  std::optional<DepthGauge> gauge_;
  size_t wanted_bur_ = 0;
  int turn_deg_ = 0;
  std::unique_ptr<render::ToothView> view_;
  std::unique_ptr<Surroundings> surroundings_;
  std::unique_ptr<TickFeed> feed_;
  std::unique_ptr<RunningAttempt> run_;  // first to go, with
  std::unique_ptr<UnrecordedRun> rehearsal_;
};

}  // namespace enamel::station::desk
