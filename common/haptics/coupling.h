#pragma once

#include <cstdint>
#include <memory>

#include "common/base/check.h"
#include "common/haptics/force_law.h"
#include "common/haptics/guard.h"

// The tick's force chain: finite check -> law -> guard -> magnitude bound -> finite check.
//
// Passivity. Let x be the true tip, p the middle of its encoder cell (|p_i - x_i| <= delta_i/2),
// e = p - a, R = Kc e, V = Kc/2 (x - a).(x - a).
//  * Moving the tip by dx while R is held: R.dx >= dV - Kc/2 dx.dx - Kc/2 sum_i delta_i |dx_i|,
//    so the device's own damping b and Coulomb friction c pay for it when Kc <= 2 b/T and
//    c_i >= Kc delta_i / 2.
//  * Moving the anchor by w changes V by Kc (w.w/2 - (x - a).w) <= Kc (w.w/2 - e.w +
//    sum_i delta_i |w_i| / 2), which is <= 0 wherever in its cell the tip is if w is scaled by
//    clamp(2 (e.w - sum_i delta_i |w_i| / 2) / w.w, 0, 1). That scaling is the guard.
// Summed over ticks: sum(R.dx) + (b/T) dx.dx + c sum |dx_i| >= -V_0. The operator never extracts
// energy, whatever the tissue, the geometry, B(t), the law's parameters or the hand do.
//  * Magnitude bound F. While the bur turns the anchor gives way, guarded like any move. At a wall (still
//    bur) the output is clipped instead: then R is the gradient of the Huber form of V, Kc e.e/2 up to
//    Kc |e| = F and F |e| - F^2 / 2 Kc beyond, which is Kc-smooth, so the same inequalities hold. F may
//    fall at any time (V falls) but a rising F would raise V by itself: while the output is clipped the
//    bound does not rise.
//  * Ticks that were not stepped: Resume lets the spring be no longer than it was.
// The premise is structural: with an anchored law the anchor moves in MoveAnchor only, after the guard,
// and in Reset, where it meets the tip and V becomes 0. The tip laws (eq. 1, eq. 17) have no anchor and
// no such proof: they are there to be compared with.
//
// Slipping laws (tank-maxwell) have two points instead of the one anchor: the rest point r of the
// spring, which makes the force, and the bur a, which is drawn and cuts. r may be moved away from the
// tip, on the energy tank's credit (guard.h; the proof is in README.md); the bur may not, it would
// leave the cut. What each does:
//  * Where tissue resists, r relaxes toward the tip as the law says and the bur goes as far as r went,
//    toward the tip and not past it. Then the law aims: r alone moves, so that the force is what the
//    hand's speed calls for.
//  * Where nothing is ahead the bur is at the tip in the same tick. The force that is still stored runs
//    out: r comes up to the tip by the tip's own way and at most 0.7 cells a tick (with fine cells 14
//    N/s), so the force falls by about Kc (v T + sqrt(3) delta) in a tick, and next to none of it is against the way out
//    (figures, and where it is more: README.md, "What falls short").
//  * Aiming asks for the damping along the hand's motion, not along the stretch: on the way out of a
//    cut nothing is ahead, and r stays where it is.
//  * Coulomb's part Fc and threshold Fth of a tissue: r and the bur feel only what the force is beyond
//    Fc, and nothing moves below Fth, so R = max(Fth, Fc + B v) in a steady cut.
//  * Saturation and walls move r, never the bur.
namespace enamel::haptics {

// What the bur touches, read at the anchor's pose.
struct Contact {
  Sym3 damping_n_s_per_m;  // B of what the bur's engaged surface cuts; zero in air
  bool engaged = false;    // any part of the bur within reach of solid, in the direction of travel
  // A still bur or the shank against solid: motion along +wall_normal (into the material) is
  // blocked, everything else is free. Zero when there is no wall.
  dvec3 wall_normal{0};
  // How far the bur may travel in a straight line before it can touch anything else, m. Zero when
  // not known; lets a step through open air be taken at once.
  double clearance_m = 0;
  // For the engaged surface, N: the part of the cutting force that does not depend on speed, and the
  // force below which the bur does not cut at all. 0: none.
  double coulomb_n = 0, threshold_n = 0;
};

// The world the coupling moves in. Implemented by the core (volume and bur), by the qualification
// suite (constant or random B) and by tests. Real-time: both methods must be safe.
class Material {
 public:
  virtual ~Material() = default;
  // Contact at the anchor for travel along `stretch_m` = p - a (metres, not normalised).
  virtual Contact ContactAt(const dvec3& anchor_m, const dvec3& stretch_m) noexcept = 0;
  // The anchor moved in a straight line; a turning bur cuts along it.
  virtual void AnchorMoved(const dvec3& from_m, const dvec3& to_m) noexcept = 0;
};

// Which bounds engaged in a tick; recorded with it.
enum CouplingFlags : uint16_t {
  kGuardEngaged = 1 << 0,    // the guard shortened an anchor step
  kPeakBounded = 1 << 1,     // magnitude bound moved the anchor (or clipped at a wall)
  kNonFiniteInput = 1 << 2,  // position or material was NaN or infinite: force 0, anchor kept
  kSubstepLimit = 1 << 3,    // the anchor could not reach its place within the bounded work
  kWallContact = 1 << 4,
  kFreeAir = 1 << 5,  // nothing engaged in the direction of travel
  kLatched = 1 << 6,  // after kNonFiniteInput: force 0 and anchor kept until Reset
};

struct CouplingParams {
  LawParams law;
  double peak_force_n = 0;    // magnitude never exceeded, N
  double max_step_m = 25e-6;  // longest anchor move before contact is read again (half a voxel)
  int max_substeps = 96;      // bound on work per tick
  int delay_ticks = 0;        // whole ticks from reading to force, as the guard is to count with
  // Where the true tip can be around the measured one; of no size: the law's resolution per axis.
  TipCell cell{};
};

struct CouplingOutput {
  dvec3 force_computed_n{0};  // -R of the law, on the operator, world frame
  dvec3 force_sent_n{0};      // after the bounds
  dvec3 anchor_m{0};
  uint16_t flags = 0;  // CouplingFlags
  uint16_t substeps = 0;
  double tank_j = 0;  // energy in the tank after the tick, J (slipping laws)
};

// Thread safety: none, one loop owns it. Real-time: Tick and Reset are safe (no allocation).
class Coupling {
 public:
  explicit Coupling(const CouplingParams& params);

  // Anchor at the tip, no force, law's history cleared, latched fault cleared: start of an attempt,
  // after a gap or fault.
  void Reset(const dvec3& tip_m) noexcept;
  // After ticks that were not stepped: the hand moved while no force was sent, so the spring must not
  // be longer than it was, or the hand would get back energy it never put in. The anchor follows by
  // what the way to the tip has grown, if that is at most max_step (a cut of the same length); the law's
  // history is cleared. A slipping law's rest point goes to the tip but for what the tank pays
  // (ResumedShare). False, and nothing done, when it has grown by more or a fault is latched: Reset is
  // all that is left.
  [[nodiscard]] bool Resume(const dvec3& tip_m, Material& material) noexcept;
  // One tick. `bound_ratio` in [0, 1] scales the peak bound (fault fade). What is not finite, in or
  // out, gives no force, and none until Reset: a fault latches until somebody acts.
  ENAMEL_REALTIME CouplingOutput Tick(const dvec3& tip_m, double bound_ratio,
                                      Material& material) noexcept;

  // Saves or restores all that the next Tick depends on but the parameters. Not real-time.
  void VisitState(StateArchive& archive);

  // The bur.
  const dvec3& anchor_m() const noexcept { return anchor_; }
  // Where the spring is at rest, and what is in the tank: V + E of the proof.
  const dvec3& rest_m() const noexcept { return law_->slips() ? rest_ : anchor_; }
  double tank_j() const noexcept { return tank_.energy_j; }
  const CouplingParams& params() const noexcept { return params_; }

 private:
  // The slipping laws' tick and its parts.
  void TickSlipping(const dvec3& tip_m, double bound_n, Material& material,
                    CouplingOutput& out) noexcept;
  Contact RelaxRest(const dvec3& tip_m, const dvec3& tip_moved, bool ahead_is_free,
                    Material& material, CouplingOutput& out) noexcept;
  double RunOutReach() const noexcept;
  dvec3 NoFasterThan(const dvec3& front, const dvec3& tip_moved, const dvec3& w,
                     double spent_m) const noexcept;
  double RanOut(const dvec3& taken, const dvec3& front) const noexcept;
  struct Ahead {
    bool elsewhere = false;  // the hand moves another way than the stretch points
    bool way_out = false;    // and next to nothing resists there
    dvec3 speed_m_per_s{0};
    Contact contact;
  };
  Ahead ReadAhead(const dvec3& tip_m, const dvec3& tip_moved, Material& material) noexcept;
  void LetGoAlong(const dvec3& tip_m, const dvec3& tip_moved, const Ahead& ahead,
                  CouplingOutput& out) noexcept;
  void AimRest(const dvec3& tip_m, const Contact& contact, CouplingOutput& out) noexcept;
  dvec3 RunOut(const dvec3& w, const dvec3& e_m, const dvec3& tip_moved,
               double spent_m) const noexcept;
  dvec3 LeftBehind(const Sym3& b, const dvec3& e, const dvec3& gap, double rate) const noexcept;
  dvec3 FrontStep(const dvec3& tip_m, const Contact& contact, const dvec3& rest_step,
                  double dt_s) const noexcept;
  // The only place where a slipping law's rest point moves. `w` is scaled by the guard; returns what was taken.
  dvec3 MoveRest(const dvec3& tip_m, const dvec3& w, CouplingOutput& out) noexcept;
  void RelaxAnchor(const dvec3& tip_m, Material& material, CouplingOutput& out) noexcept;
  void BoundMagnitude(const dvec3& tip_m, double bound_n, bool wall, Material& material,
                      CouplingOutput& out) noexcept;
  // The only place where the anchor moves. `w` is scaled by the guard; returns what was taken.
  dvec3 MoveAnchor(const dvec3& tip_m, dvec3 w, Material& material, CouplingOutput& out) noexcept;

  CouplingParams params_;
  std::unique_ptr<ForceLaw> law_;
  dvec3 anchor_{0};      // the bur
  dvec3 rest_{0};        // where a slipping law's spring is at rest
  dvec3 tip_{0};         // of the last tick
  double resisted_ = 0;  // trace of B along the stretch in the last tick ...
  double held_ = 0;      // ... and the most of it lately
  Tank tank_;
  GuardParams guard_;
  double share_ = 1;          // of the stiffness that is felt (StiffnessShare)
  double stretch_ = 0;        // |tip - anchor| after the last tick
  double clipped_at_n_ = -1;  // bound of the last tick if the output was clipped at a wall, else -1
  bool wall_ = false;
  bool latched_ = false;
};

// The guard's factor for anchor step w at stretch e and resolution delta (header comment).
double GuardFactor(const dvec3& e_m, const dvec3& w_m, const dvec3& resolution_m) noexcept;

}  // namespace enamel::haptics
