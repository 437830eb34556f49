#include "station/desk/desk_attempt.h"

#include <stdexcept>

#include "common/scene/tooth_number.h"
#include "station/devices/operators.h"

namespace enamel::station::desk {
namespace {

using render::InputEvent;
using render::Screen;

constexpr float kAside = 0.16f;    // clear of the panel
constexpr double kWheelInAir = 4;  // as fast, with the bur off

render::ViewOptions ViewOf(const PreparedAttempt& prepared) {
  render::ViewOptions view;
  view.bur = prepared.exercise.bur().metric();
  view.aside = kAside;
  view.mesial_x = scene::MesialX(prepared.scene.tooth);
  view.force_full_scale_n = static_cast<double>(prepared.profile.peak_force_mn.value) * 1e-3;
  return view;
}

int Held(const Screen& screen, int more, int less) {
  return (screen.key(more) ? 1 : 0) - (screen.key(less) ? 1 : 0);
}

}  // namespace

Result<std::unique_ptr<DeskAttempt>> DeskAttempt::Create(PreparedAttempt prepared,
                                                         const DeviceOffer& offer,
                                                         std::unique_ptr<Device> attached) {
  std::unique_ptr<DeskAttempt> attempt(new DeskAttempt(std::move(prepared)));
  const PreparedAttempt& p = attempt->prepared_;
  const core::CoreParams& params = p.header.params;
  Device* device = nullptr;
  if (attached != nullptr) {
    attempt->attached_ = std::move(attached);
    device = attempt->attached_.get();
  } else if (offer.operator_name.empty()) {
    attempt->pointer_ =
        std::make_unique<PointerDevice>(params.resolution_nm[0] * 1e-9, 1.0 / params.rate_hz);
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
  try {
    attempt->view_ = std::make_unique<render::ToothView>(
        ViewOf(p), p.core ? p.core->volume() : p.volume,
        [zones = attempt->zones_.get(), reach = attempt->reach_.get()](const cutting::Volume& now) {
          zones->Look(now);
          reach->Look(now);
        });
  } catch (const std::exception& e) {
    return Status(Code::kUnavailable, e.what(), "window");
  }
  attempt->feed_ = std::make_unique<TickFeed>(*attempt->view_, p.voxel_m(), params.rate_hz);
  return attempt;
}

DeskAttempt::~DeskAttempt() = default;

void DeskAttempt::ShowOutline(bool shown) {
  view_->ShowOutline(shown);
  if (shown && outline_ == nullptr) {
    outline_ = std::make_unique<TargetOutline>(prepared_.scene, prepared_.exercise.target,
                                               prepared_.volume);
  }
  std::vector<surface::LineSegment> lines;
  if (outline_ != nullptr && outline_->Take(lines)) view_->SetOutline(lines);
}

Status DeskAttempt::Begin(Workplace& workplace, int cpu) {
  AttemptOptions options;
  options.cpu = cpu;
  // Lateness is dangerous only for a hand that a motor holds.
  options.faults_when_late = held_->has_motors() && !simulated();
  options.observer = feed_.get();
  ENAMEL_ASSIGN_OR_RETURN(auto run, workplace.Begin(prepared_, *held_, options));
  run_ = std::move(run);
  return Status::Ok();
}

void DeskAttempt::Point(const Screen& screen, double dt_s, bool held) {
  if (!pointer_) return;
  if (held) {
    // Below a dialog: a key held down must stop tilting.
    mapping_.ReleaseKeys();
  } else {
    render::Camera& camera = view_->camera();
    mapping_.SetView(dvec3(camera.Right()), dvec3(camera.TowardViewer()),
                     // Metres a pixel: the picture is two radii high.
                     2e-3 * camera.radius_mm() / screen.height());
    mapping_.SetFine(screen.key(render::kKeyLeftShift) || screen.key(render::kKeyRightShift));
    mapping_.SetTilt(Held(screen, 'D', 'A'), Held(screen, 'W', 'S'));
    bool pedal = screen.button(render::kMouseLeft) || screen.key(render::kKeySpace);
    mapping_.SetPedal(pedal);
    bool steering = screen.button(render::kMouseRight);
    if (!steering) {
      mapping_.MoveBy(screen.cursor_x() - screen.last_cursor_x(),
                      screen.cursor_y() - screen.last_cursor_y());
      for (const InputEvent& event : screen.events()) {
        if (event.kind != InputEvent::Kind::kWheel) continue;
        mapping_.Wheel(event.y * (pedal ? 1 : kWheelInAir));
      }
    }
    mapping_.Advance(dt_s);
  }
  pointer_->Publish(mapping_.pose());
}

}  // namespace enamel::station::desk
