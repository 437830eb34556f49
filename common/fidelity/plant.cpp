#include "common/fidelity/plant.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace enamel::fidelity {

Plant::Plant(const PlantSpec& spec, Hand& hand, const dvec3& start_m)
    : spec_(spec),
      hand_(hand),
      hand_mass_(hand.mass_kg()),
      random_(spec.seed),
      noise_random_(spec.seed ^ 0x6e6f697365ull),
      tip_(start_m),
      motor_(start_m),
      pipe_(static_cast<size_t>(spec.delay_ticks) + 1, dvec3(0)) {
  const Lattice& lattice = spec_.lattice;
  const double volume = std::fabs(glm::determinant(lattice.joints));
  ENAMEL_CHECK(volume > 1e-6 && lattice.driver_cell_m >= 0 && lattice.noise_counts >= 0);
  // Cartesian cells are read without a matrix, bit for bit exact.
  joint_cells_ = lattice.joints != glm::dmat3(1);
  if (joint_cells_) from_joints_ = glm::inverse(lattice.joints);
  DrawNoise();
}

void Plant::DrawNoise() {
  const int n = spec_.lattice.noise_counts;
  if (n == 0) return;
  for (int i = 0; i < 3; ++i) noise_counts_[i] = noise_random_.Below(2 * n + 1) - n;
}

dvec3 Plant::Read() const {
  const double delta = spec_.resolution_m, driver = spec_.lattice.driver_cell_m;
  dvec3 x = joint_cells_ ? spec_.lattice.joints * motor_ : motor_;
  x = CellMiddle(x, delta);
  if (spec_.lattice.noise_counts > 0) x += noise_counts_ * delta;
  if (joint_cells_) x = from_joints_ * x;
  return driver > 0 ? glm::floor(x / driver + 0.5) * driver : x;
}

bool Plant::TickLost() { return spec_.drop_ratio > 0 && random_.Uniform() < spec_.drop_ratio; }

void Plant::Step(const dvec3& command_n) {
  // A ring of delay + 1 places: a value is read `delay_ticks` after it is written, without delay at
  // once.
  pipe_[pipe_at_] = command_n;
  pipe_at_ = (pipe_at_ + 1) % pipe_.size();
  sent_ = glm::clamp(pipe_[pipe_at_], dvec3(-spec_.peak_force_n), dvec3(spec_.peak_force_n));
  Advance();
}

void Plant::StepHeld() { Advance(); }

void Plant::Advance() {
  last_tick_s_ = spec_.tick_s;
  if (spec_.jitter_ratio > 0) last_tick_s_ *= 1 + spec_.jitter_ratio * random_.Signed();
  double dt = last_tick_s_ / spec_.substeps;
  device_ = {};
  resisted_ = -sent_;
  for (int i = 0; i < spec_.substeps; ++i) {
    Substep(i, dt, [this](const Grip& grip, double step_s) {
      if (spec_.mode_hz > 0)
        FlexibleStep(grip, step_s);
      else
        RigidStep(grip, step_s);
    });
  }
  time_s_ += last_tick_s_;
  DrawNoise();
}

dvec3 Plant::StepDamped(const Sym3& b, double peak_n) {
  ENAMEL_CHECK(spec_.mode_hz == 0 && spec_.jitter_ratio == 0);
  sent_ = dvec3(0);
  last_tick_s_ = spec_.tick_s;
  const double dt = last_tick_s_ / spec_.substeps;
  device_ = {};
  resisted_ = dvec3(0);
  for (int i = 0; i < spec_.substeps; ++i) {
    Substep(i, dt, [&](const Grip& grip, double step_s) {
      resisted_ += DampedStep(grip, b, peak_n, step_s);
    });
  }
  resisted_ /= static_cast<double>(spec_.substeps);
  time_s_ += last_tick_s_;
  DrawNoise();
  return resisted_;
}

template <typename Euler>
void Plant::Substep(int i, double dt, Euler&& step) {
  const double from_s = time_s_ + i * dt;
  Grip grip = hand_.At(from_s + 0.5 * dt);
  if (grip.prescribed) return step(hand_.At(from_s + dt), dt);
  const dvec3 tip = tip_, tip_speed = tip_speed_, motor = motor_, motor_speed = motor_speed_;
  step(grip, 0.5 * dt);
  tip_ = 2.0 * tip_ - tip;
  tip_speed_ = 2.0 * tip_speed_ - tip_speed;
  motor_ = 2.0 * motor_ - motor;
  motor_speed_ = 2.0 * motor_speed_ - motor_speed;
  if (spec_.friction_n == 0) return;
  // Friction acts on the motors' side, which is the tip of a rigid device.
  dvec3& speed = spec_.mode_hz > 0 ? motor_speed_ : tip_speed_;
  const dvec3& before = spec_.mode_hz > 0 ? motor_speed : tip_speed;
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = 0.5 * (speed[axis] + before[axis]);
    if (speed[axis] * middle <= 0) speed[axis] = 0;
  }
}

void Plant::Account(const dvec3& friction, const dvec3& damping, const dvec3& inertia) {
  const double share = 1.0 / spec_.substeps;
  device_.friction_n += friction * share;
  device_.damping_n += damping * share;
  device_.inertia_n += inertia * share;
}

dvec3 Plant::PrescribedFriction(const dvec3& speed, const dvec3& resisted) const {
  const double c = spec_.friction_n;
  dvec3 out;
  for (int i = 0; i < 3; ++i)
    out[i] = speed[i] > 0 ? c : speed[i] < 0 ? -c : -std::clamp(resisted[i], -c, c);
  return out;
}

// (m + dt (b + d) + dt^2 k) v' = m v + dt (F + k (q - x) + d q'), then the friction impulse.
Plant::Push Plant::PushOf(const Grip& grip, double dt) const {
  const double mass = spec_.mass_kg + hand_mass_;
  Push out;
  out.lead_kg = mass + dt * (spec_.damping_n_s_per_m + grip.damping_n_s_per_m) +
                dt * dt * grip.stiffness_n_per_m;
  const double rub = spec_.friction_n * dt;
  for (int i = 0; i < 3; ++i) {
    double push = sent_[i] + grip.force_n[i] +
                  grip.stiffness_n_per_m * (grip.equilibrium_m[i] - tip_[i]) +
                  grip.damping_n_s_per_m * grip.equilibrium_speed_m_per_s[i];
    double impulse = mass * tip_speed_[i] + dt * push;
    out.impulse[i] = impulse > rub ? impulse - rub : impulse < -rub ? impulse + rub : 0;
    out.friction_n[i] = (impulse - out.impulse[i]) / dt;
  }
  return out;
}

void Plant::RigidStep(const Grip& grip, double dt) {
  const dvec3 was = tip_speed_;
  dvec3 friction;
  if (grip.prescribed) {
    tip_speed_ = (grip.equilibrium_m - tip_) / dt;
    tip_ = grip.equilibrium_m;
    friction = PrescribedFriction(tip_speed_, -sent_);
  } else {
    const Push push = PushOf(grip, dt);
    friction = push.friction_n;
    for (int i = 0; i < 3; ++i) {
      tip_speed_[i] = push.impulse[i] / push.lead_kg;
      tip_[i] += dt * tip_speed_[i];
    }
  }
  motor_ = tip_;
  Account(friction, tip_speed_ * spec_.damping_n_s_per_m,
          (tip_speed_ - was) * (spec_.mass_kg / dt));
}

dvec3 Plant::DampedStep(const Grip& grip, const Sym3& b, double peak, double dt) {
  auto Within = [peak](dvec3 force) {
    const double length = glm::length(force);
    return length > peak ? force * (peak / length) : force;
  };
  const dvec3 was = tip_speed_;
  dvec3 resisted, friction;
  if (grip.prescribed) {
    tip_speed_ = (grip.equilibrium_m - tip_) / dt;
    tip_ = grip.equilibrium_m;
    resisted = Within(b * tip_speed_);
    friction = PrescribedFriction(tip_speed_, resisted);
  } else {
    const Push push = PushOf(grip, dt);
    friction = push.friction_n;
    tip_speed_ = SolveShifted(b * dt, push.lead_kg, push.impulse);
    const dvec3 wanted = b * tip_speed_;
    resisted = Within(wanted);
    if (resisted != wanted) tip_speed_ = (push.impulse - resisted * dt) / push.lead_kg;
    tip_ += tip_speed_ * dt;
  }
  motor_ = tip_;
  Account(friction, tip_speed_ * spec_.damping_n_s_per_m,
          (tip_speed_ - was) * (spec_.mass_kg / dt));
  return resisted;
}

// Motor mass with b and c, spring and damper of the mode, tip mass with the hand: 2 x 2 implicit
// solve.
void Plant::FlexibleStep(const Grip& grip, double dt) {
  double tip_mass = spec_.mass_kg * spec_.mode_tip_share, motor_mass = spec_.mass_kg - tip_mass;
  double reduced = tip_mass * motor_mass / spec_.mass_kg, w = 2 * M_PI * spec_.mode_hz;
  double ks = reduced * w * w, ds = 2 * spec_.mode_damping_ratio * reduced * w;
  tip_mass += hand_mass_;
  double link = dt * ds + dt * dt * ks, rub = spec_.friction_n * dt;
  double kh = grip.stiffness_n_per_m, dh = grip.damping_n_s_per_m;
  const double device_tip_kg = spec_.mass_kg * spec_.mode_tip_share;
  const dvec3 tip_was = tip_speed_, motor_was = motor_speed_;
  dvec3 friction;
  auto left_of = [rub](double impulse) {
    return impulse > rub ? impulse - rub : impulse < -rub ? impulse + rub : 0;
  };
  double m11 = motor_mass + dt * spec_.damping_n_s_per_m + link;
  double m22 = tip_mass + dt * dh + dt * dt * kh + link;
  for (int i = 0; i < 3; ++i) {
    double spring = dt * ks * (tip_[i] - motor_[i]);
    double r1 = motor_mass * motor_speed_[i] + dt * sent_[i] + spring;
    double r2 = tip_mass * tip_speed_[i] - spring +
                dt * (grip.force_n[i] + kh * (grip.equilibrium_m[i] - tip_[i]) +
                      dh * grip.equilibrium_speed_m_per_s[i]);
    if (grip.prescribed) {
      tip_speed_[i] = (grip.equilibrium_m[i] - tip_[i]) / dt;
      const double impulse = r1 + link * tip_speed_[i], left = left_of(impulse);
      friction[i] = (impulse - left) / dt;
      motor_speed_[i] = left / m11;
    } else {
      // Eliminate the tip, then friction on the motor side.
      const double lead = m11 - link * link / m22, impulse = r1 + link * r2 / m22,
                   left = left_of(impulse);
      friction[i] = (impulse - left) / dt;
      motor_speed_[i] = left / lead;
      tip_speed_[i] = (r2 + link * motor_speed_[i]) / m22;
    }
    motor_[i] += dt * motor_speed_[i];
    tip_[i] = grip.prescribed ? grip.equilibrium_m[i] : tip_[i] + dt * tip_speed_[i];
  }
  Account(friction, motor_speed_ * spec_.damping_n_s_per_m,
          ((motor_speed_ - motor_was) * motor_mass + (tip_speed_ - tip_was) * device_tip_kg) *
              (1 / dt));
}

}  // namespace enamel::fidelity
