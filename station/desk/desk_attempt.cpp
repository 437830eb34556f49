#include "station/desk/desk_attempt.h"

#include <algorithm>
#include <stdexcept>

#include "common/scene/tooth_number.h"
#include "station/devices/operators.h"

namespace enamel::station::desk {
namespace {

using render::InputEvent;
using render::Screen;

constexpr float kAside = 0.16f;    // clear of the panel
constexpr double kWheelInAir = 4;  // as fast, with the bur off
constexpr double kStartAbove_m = 2e-3, kCavity_m = 3e-3;
constexpr double kWork_m = 4e-3;

// The mouse begins above the place to cut, where its bur is seen: the device's centre is 8 mm up.
// `around_m`: above what is highest within this distance too, so that a resumed attempt does not
// begin within its cavity.
dvec3 StartOf(const core::CoreParams& params, const cutting::Volume& volume, double around_m) {
  dvec3 centre(0);
  for (int i = 0; i < 3; ++i) {
    centre[i] = static_cast<double>(params.device_origin_nm[static_cast<size_t>(i)]) * 1e-9;
  }
  const double step_m = volume.spec().voxel_m(), deepest_m = PointerSettings().reach_m;
  for (double down_m = 0; down_m < deepest_m; down_m += step_m) {
    for (const dvec3& aside : {dvec3(0), dvec3(around_m, 0, 0), dvec3(-around_m, 0, 0),
                               dvec3(0, around_m, 0), dvec3(0, -around_m, 0)}) {
      if (volume.DistanceAt_m(centre + aside - dvec3(0, 0, down_m)) >= 0) continue;
      return {0, 0, std::min(0.0, kStartAbove_m - down_m)};
    }
  }
  return dvec3(0);
}

// `more`, `less`: places of the keyboard.
int Held(const Screen& screen, int more, int less) {
  return (screen.key(screen.KeyAt(more)) ? 1 : 0) - (screen.key(screen.KeyAt(less)) ? 1 : 0);
}

}  // namespace

render::ViewOptions ViewOf(const scene::Scene& scene, const scene::Exercise& exercise) {
  render::ViewOptions view;
  view.burs.clear();
  for (const scene::BurSpec& bur : exercise.burs()) view.burs.push_back(bur.metric());
  view.aside = kAside;
  view.crown_aside = scene.up == scene::Up::kBuccal;
  view.mesial_x = scene::MesialX(scene.tooth);
  const scene::CavityTarget& target = exercise.target;
  if (const auto at = scene.landmarks.find(target.landmark); at != scene.landmarks.end()) {
    view.work_m = dvec3(at->second[0], at->second[1], at->second[2]) * 1e-6;
    view.work_radius_m =
        std::max(kWork_m, 2.6e-6 * std::max(target.half_size_um[0], target.half_size_um[1]));
  }
  return view;
}

render::ViewOptions ViewOf(const PreparedAttempt& prepared) {
  render::ViewOptions view = ViewOf(prepared.scene, prepared.exercise);
  view.force_full_scale_n = static_cast<double>(prepared.profile.peak_force_mn.value) * 1e-3;
  return view;
}

Result<std::unique_ptr<DeskAttempt>> DeskAttempt::Create(PreparedAttempt prepared,
                                                         const DeviceOffer& offer,
                                                         std::unique_ptr<Device> attached,
                                                         bool mouth) {
  std::unique_ptr<DeskAttempt> attempt(new DeskAttempt(std::move(prepared)));
  const PreparedAttempt& p = attempt->prepared_;
  const core::CoreParams& params = p.header.params;
  Device* device = nullptr;
  if (attached != nullptr) {
    attempt->attached_ = std::move(attached);
    device = attempt->attached_.get();
  } else if (offer.operator_name.empty()) {
    PointerSettings settings;
    settings.start_m =
        p.core ? StartOf(params, p.core->volume(), kCavity_m) : StartOf(params, p.volume, 0);
    attempt->mapping_.emplace(settings);
    attempt->pointer_ = std::make_unique<PointerDevice>(params.resolution_nm[0] * 1e-9,
                                                        1.0 / params.rate_hz, settings.start_m);
    device = attempt->pointer_.get();
  } else {
    const OperatorPreset* preset = FindOperator(offer.operator_name);
    ENAMEL_CHECK(preset != nullptr);
    ENAMEL_ASSIGN_OR_RETURN(
        auto made, MakeSimulatedDevice(*preset, p.scene, p.exercise, p.profile, params, p.volume));
    attempt->simulated_ = std::move(made);
    device = attempt->simulated_.get();
  }
  attempt->held_ = std::make_unique<HeldDevice>(*device);
  ENAMEL_RETURN_IF_ERROR(UseHandOf(attempt->prepared_, *device));
  attempt->zones_ = std::make_unique<ZoneWatch>(p.scene, p.exercise.target, p.volume);
  attempt->reach_ = std::make_unique<ReachWatch>(p.scene, p.exercise.target, p.volume);
  attempt->nearness_ = std::make_unique<NearnessWatch>(core::BursOf(params), p.volume);
  attempt->gauge_.emplace(p.scene, p.exercise.target, core::BursOf(params), p.volume);
  // Of a resumed attempt the tooth as it was cut.
  const cutting::Volume& cut = p.core ? p.core->volume() : p.volume;
  try {
    attempt->view_ = std::make_unique<render::ToothView>(
        ViewOf(p), cut,
        [zones = attempt->zones_.get(), reach = attempt->reach_.get(),
         nearness = attempt->nearness_.get()](const cutting::Volume& now) {
          nearness->Look();
          zones->Look(now);
          reach->Look(now);
        },
        &p.volume);
  } catch (const std::exception& e) {
    return Status(Code::kUnavailable, e.what(), "window");
  }
  attempt->surroundings_ = std::make_unique<Surroundings>(p.scene, p.exercise, p.volume, mouth);
  attempt->feed_ = std::make_unique<TickFeed>(*attempt->view_, p.voxel_m(), params.rate_hz);
  return attempt;
}

DeskAttempt::~DeskAttempt() = default;

void DeskAttempt::LeaveAtOnce() {
  if (run_ != nullptr) (void)run_->Leave();
  if (rehearsal_ != nullptr) rehearsal_->End();
  // The loop that used it has ended; HeldDevice keeps only its address.
  attached_.reset();
}

bool DeskAttempt::turns_with_view() const {
  const core::CoreParams& params = prepared_.header.params;
  return attached_ != nullptr && params.peak_torque_un_m == 0 && !params.spring_on_board;
}

dvec3 DeskAttempt::hand_m() const {
  const auto counts = held_->own_counts();
  dvec3 out;
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<size_t>(i);
    out[i] = 1e-9 * counts[at] * prepared_.header.params.resolution_nm[at];
  }
  return out;
}

Warned DeskAttempt::warned() const {
  const render::FrameState& now = view_->state();
  if (!view_->has_state() || !now.bur_on) return {};
  return nearness_->Near(now.anchor, now.bur);
}

void DeskAttempt::WriteBesideBur(const language::Words& words, const Screen& screen, bool depth,
                                 const Warned& warned) const {
  if (!view_->has_state()) return;
  const render::FrameState& now = view_->state();
  WriteBeside(now.anchor.tip_m,
              depth ? gauge_->Text(words, gauge_->At(now.anchor, now.bur)) : std::string(),
              NearText(words, warned), view_->camera(), screen.fonts(), screen.width(),
              screen.height());
}

bool DeskAttempt::drawn() {
  if (auto found = surroundings_->Take()) {
    view_->SetOutline(found->outline);
    view_->SetScenery(found->mouth);
  }
  return surroundings_->done() && view_->WaitIdle(std::chrono::milliseconds(0));
}

AttemptOptions DeskAttempt::OptionsFor(int cpu) const {
  AttemptOptions options;
  options.cpu = cpu;
  // Lateness is dangerous only for a hand that a motor holds.
  options.faults_when_late = held_->has_motors() && !simulated();
  options.observer = feed_.get();
  return options;
}

void DeskAttempt::Rehearse(int cpu) {
  std::unique_ptr<core::Core> core;
  if (rehearsal_ != nullptr) {
    core = rehearsal_->TakeCore();
  } else if (run_ != nullptr) {
    core = run_->TakeCore();
  } else {
    core = std::make_unique<core::Core>(prepared_.header.params, prepared_.volume);
  }
  wanted_bur_ = core->bur();
  // To the one before, the gap that this begins with would be a recording that stalled.
  feed_ = std::make_unique<TickFeed>(*view_, prepared_.voxel_m(), prepared_.header.params.rate_hz);
  rehearsal_ = std::make_unique<UnrecordedRun>(std::move(core), prepared_, *held_, OptionsFor(cpu));
}

void DeskAttempt::NextBur() {
  TickLoop* loop = rehearsal_ != nullptr ? &rehearsal_->loop()
                   : run_ != nullptr     ? &run_->loop()
                                         : nullptr;
  if (loop == nullptr) return;
  wanted_bur_ = (wanted_bur_ + 1) % core::BurCount(prepared_.header.params);
  loop->WantBur(wanted_bur_);
}

Snapshot DeskAttempt::newest() {
  if (rehearsal_ != nullptr) return rehearsal_->snapshot();
  return run_ != nullptr ? run_->snapshot() : Snapshot();
}

bool DeskAttempt::lacks_realtime() const {
  if (!held_->has_motors() || simulated()) return false;
  return rehearsal_ != nullptr ? rehearsal_->lacks_realtime()
                               : run_ != nullptr && run_->lacks_realtime();
}

Status DeskAttempt::Begin(Workplace& workplace, int cpu) {
  // As the loop begins: the first, or the one that was in use when the attempt was cut off.
  wanted_bur_ = prepared_.core ? prepared_.core->bur() : 0;
  ENAMEL_ASSIGN_OR_RETURN(auto run, workplace.Begin(prepared_, *held_, OptionsFor(cpu)));
  run_ = std::move(run);
  return Status::Ok();
}

void DeskAttempt::Point(const Screen& screen, double dt_s, bool held) {
  if (!pointer_) return;
  PointerMapping& mapping = *mapping_;
  if (held) {
    // Below a dialog: a key held down must stop tilting.
    mapping.ReleaseKeys();
  } else {
    render::Camera& camera = view_->camera();
    mapping.SetView(dvec3(camera.Right()), dvec3(camera.TowardViewer()),
                    // Metres a pixel: the picture is two radii high, an upright one as wide.
                    2e-3 * camera.radius_mm() / screen.shorter_side());
    mapping.SetFine(screen.key(render::kKeyLeftShift) || screen.key(render::kKeyRightShift));
    // Two sets of keys, for the hand that does not hold the mouse.
    mapping.SetTilt(Held(screen, 'D', 'A') + Held(screen, 'L', 'J'),
                    Held(screen, 'W', 'S') + Held(screen, 'I', 'K'));
    bool pedal = screen.button(render::kMouseLeft) || screen.key(render::kKeySpace);
    mapping.SetPedal(pedal);
    bool steering = screen.button(render::kMouseRight) || render::HoldsMirror(screen, *view_);
    if (!steering) {
      mapping.MoveBy(screen.moved_x(), screen.moved_y());
      for (const InputEvent& event : screen.events()) {
        if (event.kind == InputEvent::Kind::kKey && event.code == 'B' && event.pressed) {
          mapping.Recall();
        }
        if (event.kind != InputEvent::Kind::kWheel) continue;
        mapping.Wheel(event.y * (pedal ? 1 : kWheelInAir));
      }
    }
    mapping.Advance(dt_s);
  }
  pointer_->Publish(mapping.pose());
}

}  // namespace enamel::station::desk
