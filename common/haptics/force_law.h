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
// e = p - a, R resisting force, F = -R force on the operator, T tick, delta resolution.
namespace enamel::haptics {

// Stable numbers: they are recorded in attempt headers.
enum class LawKind : uint8_t {
  kMaxwell = 1,       // spring Kc to an anchor that moves through tissue as F/B
  kPaperDamping = 2,  // eq. 1: R = B V, V = (p_i - p_{i-1}) f, nothing else
  kPaperLimited = 3,  // eq. 1 with the limiter of eq. 17 exactly as printed
  kLeadMaxwell = 4,   // Maxwell whose spring is stiffer for slow motion than for fast (default)
  kPaperSymmetric =
      5,  // eq. 1 with eq. 12's slope bound on rises and falls, per axis, adaptive window
  kVirtualCoupling = 6,  // Adams-Hannaford: spring and damper to a tool that moves through tissue
  kPassivityControlled = 7,  // eq. 1 with a passivity observer and controller (Hannaford-Ryu)
  kEnergyBounded = 8,        // eq. 1 under the energy bound (Kim-Ryu)
};

// The default law of new exercises, suites and benchmarks.
inline constexpr LawKind kDefaultLaw = LawKind::kLeadMaxwell;

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
  // Farthest that two readings of a tip at rest can lie apart, m. Coupling sets it from the tip's cell.
  double play_m = 0;
};

// How an anchored law would pull the bur where it is: R = stiffness * stretch.
struct Pull {
  dvec3 stretch_m{0};
  double stiffness_n_per_m = 0;
};

// One force law. A law is of one of two families:
//  * anchored: the bur is at an anchor. The law says how hard the spring pulls there, the coupling moves
//    the bur through tissue as R/B, and the spring's rest point, by guarded steps, to where the spring
//    gives R (coupling.h);
//  * tip: the bur is at the tip, the law gives the force directly.
// Thread safety: none, one instance per loop. Real-time: every method but construction is safe.
class ForceLaw {
 public:
  virtual ~ForceLaw() = default;

  virtual bool anchored() const noexcept = 0;
  // Forgets all history; the tip is at tip_m and at rest.
  virtual void Reset(const dvec3& tip_m) noexcept = 0;
  // Once per tick, before PullOn or TipForce: the newest tip position.
  virtual void BeginTick(const dvec3& tip_m) noexcept = 0;
  // Anchored laws: the pull on a bur at anchor_m in material b (N s/m), which resists in some direction.
  // May be asked again in a tick as the bur moves. Requires 0 <= s.e and |s| <= |e| of the stretch s:
  // the bur is pulled toward the tip and not past it.
  virtual Pull PullOn(const dvec3& anchor_m, const Sym3& b) noexcept {
    (void)anchor_m;
    (void)b;
    return {};
  }
  // Anchored laws: nothing resists the bur. Whatever the law remembers of the tip's way is void.
  virtual void PassAir() noexcept {}
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

// n Kc of lead Maxwell in tissue b (N s/m): what slow and wide motion meets there.
double LeadStiffness(double kc_n_per_m, double b_n_s_per_m) noexcept;

// Factories, one per law file.
std::unique_ptr<ForceLaw> MakeMaxwell(const LawParams& params);
std::unique_ptr<ForceLaw> MakeLeadMaxwell(const LawParams& params);
std::unique_ptr<ForceLaw> MakePaperDamping(const LawParams& params);
std::unique_ptr<ForceLaw> MakePaperLimited(const LawParams& params);
std::unique_ptr<ForceLaw> MakePaperSymmetric(const LawParams& params);
std::unique_ptr<ForceLaw> MakeVirtualCoupling(const LawParams& params);
std::unique_ptr<ForceLaw> MakePassivityControlled(const LawParams& params);
std::unique_ptr<ForceLaw> MakeEnergyBounded(const LawParams& params);

}  // namespace enamel::haptics
