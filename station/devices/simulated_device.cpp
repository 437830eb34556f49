#include "station/devices/simulated_device.h"

#include <cmath>

#include "common/core/params.h"
#include "common/haptics/turning.h"
#include "station/devices/limited.h"

namespace enamel::station {
namespace {

constexpr double kRecordedCell_rad = core::kMinRotationCell_urad * 1e-6;

// One axis of a mass with damping and friction over dt, by the trapezoidal rule.
double Pushed(double v, double push, double mass, double damping, double friction, double dt) {
  const double half_decay = 0.5 * damping * dt / mass, stop = friction * dt / mass;
  v = (v * (1 - half_decay) + push * dt / mass) / (1 + half_decay);
  return std::fabs(v) <= stop ? 0 : v - std::copysign(stop, v);
}

}  // namespace

SimulatedDevice::SimulatedDevice(const PlantParams& params, std::unique_ptr<SimulatedOperator> op)
    : params_(params),
      count_m_(params.count_m > 0 ? params.count_m : params.resolution_m),
      operator_(std::move(op)),
      random_(params.seed) {
  ENAMEL_CHECK(operator_ != nullptr);
  ENAMEL_CHECK(params_.mass_kg > 0 && params_.resolution_m > 0 && params_.substeps > 0);
  ENAMEL_CHECK(params_.delay_ticks >= 0 && params_.delay_ticks <= kMaxDelay);
  x_ = bur_m_ = operator_->Start_m();
}

Hand SimulatedDevice::hand() const {
  return MakeHand(HandKind::kProgram, "simulated device", "operator " + operator_->Name());
}

std::string SimulatedDevice::Name() const {
  return "simulated device, held by " + operator_->Name();
}

DeviceSample SimulatedDevice::ReadSample() noexcept {
  HandDrive hand = operator_->Act(x_, bur_m_, params_.tick_s);
  // The newest force goes in; the force sent delay_ticks ago comes out.
  const size_t size = pipe_.size(), delay = static_cast<size_t>(params_.delay_ticks);
  pipe_[pipe_at_] = sent_n_;
  motor_n_ = pipe_[(pipe_at_ + size - delay) % size];
  torques_[pipe_at_] = sent_n_m_;
  motor_n_m_ = torques_[(pipe_at_ + size - delay) % size];
  pipe_at_ = (pipe_at_ + 1) % size;
  double dt = params_.tick_s / params_.substeps;
  dvec3 equilibrium = hand.equilibrium_m - hand.velocity_m_per_s * params_.tick_s;
  for (int i = 0; i < params_.substeps; ++i) {
    equilibrium += hand.velocity_m_per_s * dt;
    Substep(hand, equilibrium, dt);
    if (params_.inertia_kg_m2 > 0) Turn(hand, dt);
  }
  DeviceSample sample;
  const dvec3 reading = ReadTip();
  for (int i = 0; i < 3; ++i)
    sample.counts[static_cast<size_t>(i)] =
        static_cast<int32_t>(std::lround(reading[i] / count_m_));
  // A gimbal without motors follows the hand.
  sample.orientation = ToQuantised(params_.inertia_kg_m2 > 0 ? Read(turned_) : hand.orientation);
  if (hand.pedal) {
    sample.buttons |= kPedal;
    sample.bur_speed_krpm = kTurbineSpeed_krpm;
  }
  progress_.store(operator_->Progress(), std::memory_order_relaxed);
  if (hand.finished) sample.buttons |= kFinish;
  return sample;
}

// The middle of the encoders' cell, from the place of counts 0, 0, 0.
dvec3 SimulatedDevice::ReadTip() noexcept {
  const dvec3 noise{Noise(), Noise(), Noise()};
  const dvec3 cells = params_.joints * (x_ + noise - params_.origin_m) / params_.resolution_m;
  const dvec3 read(std::round(cells.x), std::round(cells.y), std::round(cells.z));
  return glm::transpose(params_.joints) * read * params_.resolution_m;
}

void SimulatedDevice::SendForceAndTorque(const dvec3& force_n, const dvec3& torque_n_m) noexcept {
  sent_n_ = Limited(force_n, params_.peak_force_n);
  sent_n_m_ = Limited(torque_n_m, params_.peak_torque_n_m);
}

// Nearly normal: the sum of twelve uniform numbers, less its mean, has variance 1.
double SimulatedDevice::Noise() noexcept {
  if (params_.noise_m == 0) return 0;
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random_.Uniform();
  return params_.noise_m * sum;
}

void SimulatedDevice::Substep(const HandDrive& hand, const dvec3& equilibrium_m,
                              double dt) noexcept {
  x_ += v_ * (0.5 * dt);
  double mass = params_.mass_kg + params_.hand_mass_kg;
  dvec3 push = (equilibrium_m - x_) * hand.stiffness_n_per_m +
               (hand.velocity_m_per_s - v_) * hand.damping_n_s_per_m;
  dvec3 force = Limited(push, hand.max_force_n) + motor_n_;
  for (int i = 0; i < 3; ++i) {
    v_[i] = Pushed(v_[i], force[i], mass, params_.damping_n_s_per_m, params_.friction_n, dt);
  }
  x_ += v_ * (0.5 * dt);
}

// As Substep, with angles for lengths. Without gyroscopic torque: a hand turns slowly.
void SimulatedDevice::Turn(const HandDrive& hand, double dt) noexcept {
  turned_ = haptics::TurnedBy(spin_ * (0.5 * dt), turned_);
  const dvec3 torque = haptics::ChordOfTurn(hand.orientation, turned_) * params_.hand_n_m_per_rad -
                       spin_ * params_.hand_n_m_s + motor_n_m_;
  for (int i = 0; i < 3; ++i) {
    spin_[i] = Pushed(spin_[i], torque[i], params_.inertia_kg_m2, params_.rotational_damping_n_m_s,
                      params_.rotational_friction_n_m, dt);
  }
  turned_ = haptics::TurnedBy(spin_ * (0.5 * dt), turned_);
}

// Counts of the vector part, as coarse as the cell permits: with step s its error is at most
// sqrt(3) s / 2, and the angle's twice that over w. Exact to a hundredth up to 15 degrees of tilt;
// beyond, the cell is larger than stated by 1/w.
Quat SimulatedDevice::Read(const Quat& q) const noexcept {
  const double sign = q.w < 0 ? -1 : 1;
  const double step = (params_.orientation_cell_rad - kRecordedCell_rad) / std::sqrt(3.0);
  if (!(step > 0)) return q;
  auto counted = [&](double v) { return step * std::round(sign * v / step); };
  Quat out{counted(q.x), counted(q.y), counted(q.z), 0};
  const double rest = 1 - out.x * out.x - out.y * out.y - out.z * out.z;
  out.w = rest > 0 ? std::sqrt(rest) : 0;
  return out.Normalised();
}

}  // namespace enamel::station
