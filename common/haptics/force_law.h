#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "common/haptics/estimator.h"
#include "common/math/sym3.h"
#include "common/math/vec.h"

// Force laws: what resisting force a moving bur feels in material of damping matrix B.
// Notation as in Liu et al. 2008: p tip (middle of its encoder cell), a anchor (the simulated bur),
// e = p - a, R = Kc e resisting force, F = -R force on the operator, T tick, delta resolution.
namespace enamel::haptics {

// Stable numbers: they are recorded in attempt headers.
enum class LawKind : uint8_t {
  kMaxwell = 1,       // spring Kc to an anchor that moves through tissue as F/B
  kPaperDamping = 2,  // eq. 1: R = B V, V = (p_i - p_{i-1}) f, nothing else
  kPaperLimited = 3,  // eq. 1 with the limiter of eq. 17 exactly as printed
  kGatedMaxwell = 4,  // Maxwell whose anchor waits while the force is too small for the speed
  kPaperSymmetric =
      5,  // eq. 1 with eq. 12's slope bound on rises and falls, per axis, adaptive window
  kVirtualCoupling = 6,  // Adams-Hannaford: spring and damper to a tool that moves through tissue
  kPassivityControlled = 7,  // eq. 1 with a passivity observer and controller (Hannaford-Ryu)
  kEnergyBounded = 8,        // eq. 1 under the energy bound (Kim-Ryu)
  kTankMaxwell =
      9,  // gated Maxwell that may also lengthen its spring, paid for by an energy tank (default)
};

// The default law of new exercises, suites and benchmarks.
inline constexpr LawKind kDefaultLaw = LawKind::kTankMaxwell;

// The parameters of every law of one device. SI units.
struct LawParams {
  LawKind kind = LawKind::kMaxwell;
  double kc_n_per_m = 0;  // stiffness the renderer may use, <= the device's passive limit
  dvec3 resolution_m{0};  // encoder cell per axis, delta
  double tick_s = 0.001;  // T
  // eq. 17 divides by dp.dp, which is 0 on most ticks at cutting speed. The stated rule there:
  // false: hold R_{i-1} (a pure spring Kc up to saturation); true: pass R_c through.
  bool pass_through_at_rest = false;
  // Velocity for the laws that need one (eq1, eq17, eq17-symmetric, eq1-popc, eq1-bounded). The anchored
  // laws do not look at it. The core leaves it to the law; the qualification suite tries them all.
  EstimatorParams estimator{};
  double peak_force_n = 0;  // of the device: bounds what a slipping law aims at. 0: no bound
};

// One force law. A law is of one of two families:
//  * anchored: the bur is at the anchor, the law says how the stretch e relaxes in time dt;
//  * tip: the bur is at the tip, the law gives the force directly.
// Thread safety: none, one instance per loop. Real-time: every method but construction is safe.
class ForceLaw {
 public:
  virtual ~ForceLaw() = default;

  virtual bool anchored() const noexcept = 0;
  // Forgets all history; the tip is at tip_m and at rest.
  virtual void Reset(const dvec3& tip_m) noexcept = 0;
  // Once per tick, before Relax or TipForce: the newest tip position.
  virtual void BeginTick(const dvec3& tip_m) noexcept = 0;
  // Anchored laws: the stretch after dt_s in material b (N s/m), from stretch e_m. The result must
  // be P e with 0 <= P <= I (the anchor moves toward the tip, never past it and never away); the
  // guard in coupling.h then makes the step passive under quantisation.
  virtual dvec3 Relax(const dvec3& e_m, const Sym3& b, double dt_s) noexcept {
    (void)b;
    (void)dt_s;
    return e_m;
  }
  // Slipping laws: anchored laws whose spring's rest point may leave the bur (coupling.h).
  virtual bool slips() const noexcept { return false; }
  // Slipping laws, after Relax: the hand's speed as estimated in this tick, m/s; and the stretch that is
  // wanted from stretch e_m where b is the damping met along that speed. Not bound by P: the tank pays.
  virtual dvec3 speed_m_per_s() const noexcept { return dvec3(0); }
  virtual dvec3 Aim(const dvec3& e_m, const Sym3& b) noexcept {
    (void)b;
    return e_m;
  }
  // Tip laws: resisting force R (N, against motion) in material b.
  virtual dvec3 TipForce(const Sym3& b) noexcept {
    (void)b;
    return dvec3(0);
  }
  // Saves or restores all that the next tick depends on but the parameters.
  virtual void VisitState(StateArchive& archive) = 0;
};

// A new law is one file and one line in the registry (force_law.cpp).
struct LawEntry {
  LawKind kind;
  std::string_view name;  // as on command lines and in JSON: "maxwell", "eq1", "eq17"
  std::string_view summary;
  std::unique_ptr<ForceLaw> (*make)(const LawParams&);
};
std::span<const LawEntry> ForceLaws();
// nullptr when the name or kind is unknown.
const LawEntry* FindLaw(std::string_view name);
const LawEntry* FindLaw(LawKind kind);

// Factories, one per law file.
std::unique_ptr<ForceLaw> MakeMaxwell(const LawParams& params);
std::unique_ptr<ForceLaw> MakeGatedMaxwell(const LawParams& params);
std::unique_ptr<ForceLaw> MakeTankMaxwell(const LawParams& params);
std::unique_ptr<ForceLaw> MakePaperDamping(const LawParams& params);
std::unique_ptr<ForceLaw> MakePaperLimited(const LawParams& params);
std::unique_ptr<ForceLaw> MakePaperSymmetric(const LawParams& params);
std::unique_ptr<ForceLaw> MakeVirtualCoupling(const LawParams& params);
std::unique_ptr<ForceLaw> MakePassivityControlled(const LawParams& params);
std::unique_ptr<ForceLaw> MakeEnergyBounded(const LawParams& params);

}  // namespace enamel::haptics
