#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/fidelity/plant.h"
#include "common/haptics/coupling.h"
#include "common/haptics/guard.h"
#include "common/scene/types.h"
#include "station/lab/suites/findings.h"

// Games against the theorem of common/haptics/README.md ("Why it is passive"), in the order of common/core:
// gap, Resume or Suspend, a tick that gives force at once. The adversary is more than the hand: delay, noise,
// turned lattices, bounds that jump, gaps, late ticks, the loop's rate. Each game is played at the least
// damping and friction that its own clause allows, so that no reserve of the device can hide a mistake. SI
// units. Thread safety: one Game per thread.
namespace enamel::station::lab {

using fidelity::CellMiddle;
using fidelity::Random;

// The adversary's means besides moving the tip and choosing B every tick.
struct GameRules {
  enum class Late : uint8_t { kNone, kCovered, kLeak };

  double rate_hz = 1000;  // Kc is the clause's there
  int delay_ticks = 0;
  int noise_counts = 0;        // each reading is off by up to that many counts per axis
  bool lattice = false;        // cells are those of joints turned any way, recorded to kRecorded_nm
  bool driver_rounds = false;  // or rounded by the driver to its own cells of the same edge
  bool bounds = false;         // the bound on the force jumps every tick, to 0 and from 0
  bool gaps = false;           // ticks are not stepped: the force stops, the tip moves on
  // Occasionally a force is felt for two ticks. Either the device missed a new force or the
  // coupling a tick (covered by the clause of one more tick of delay), or it lasts only a tick,
  // without delay, and the leak that README.md names is added to the balance.
  Late late = Late::kNone;
  // What the theorem excludes, and the games must find: delay and noise that guard and clause do not
  // know, and Kc as a multiple of the clause's.
  int untold_ticks = 0, untold_counts = 0;
  double over_clause = 1;

  int counts_off() const { return noise_counts + untold_counts; }
  int clause_ticks() const { return delay_ticks + (late == Late::kCovered ? 1 : 0); }
  // The profile's cell under these rules, as scene/cell.h knows it.
  scene::DeviceProfile ProfileOf(const DeviceModel& model) const;
  std::string Name() const;
};

// What drivers of joint devices record the tip to, nm (scene/builtin/profiles.cpp).
inline constexpr int32_t kRecorded_nm = 500;

// The guard's cell, through the parameters of a recording: whole nanometres, rounded up.
haptics::TipCell CellUnder(const DeviceModel& model, const GameRules& rules);
// Largest stiffness the rules' clause lets this device use, at most the model's at that rate, times
// over_clause. N/m, whole, as a profile has it.
double ClauseStiffness(const DeviceModel& model, const GameRules& rules);

// What is attacked.
struct Target {
  // None: a bare spring whose rest point the adversary moves with only the guard in between.
  std::optional<haptics::LawKind> law;
  bool core = false;  // with all of common/core: tooth, bur, recorded counts, suspension
  // The device has half more friction than the cell needs, and the law knows all of it: it pushes with the rest.
  bool spare = false;

  std::string Name() const;
};
// The device's friction, N: the clause's least, and half more where it has some to spare. The law gets it as measured.
double ClauseFriction(const DeviceModel& model, const GameRules& rules, const Target& target);
// Whether the theorem covers this target under these rules.
bool Covered(const Target& target, const GameRules& rules);

// A tick of the core: what is read, and what the adversary lets it meet.
struct SubjectTick {
  dvec3 tip_m{0};
  int gap_ticks = 0;  // not stepped before this one, and without force
  double bound_ratio = 1;
  haptics::Contact contact;
  FeedForce load;   // where contact.by_load
  dvec3 drag_n{0};  // there too: of any size and direction
  dvec3 push_m{0};  // wish for the rest point; a coupling ignores it
};

class Subject {
 public:
  virtual ~Subject() = default;
  // Once: the tip at rest, force on and 0.
  virtual void Start(const dvec3& tip_m) = 0;
  // As core::Core::Step: resisting force to send.
  virtual dvec3 Step(const SubjectTick& tick) = 0;
  // What is in the tank. None: not known, and the force is off at the start.
  virtual std::optional<double> tank_j() const = 0;
  // Energy in its spring with the tip at `x_m`. None: the last force says it.
  virtual std::optional<double> stored_j(const dvec3& /*x_m*/) const { return std::nullopt; }
  // Times the force came on after ticks without one, each with a count of energy of its own.
  virtual int restarts() const = 0;
};

// subjects.cpp and core_subject.cpp. `energy_j`: in the bare spring's tank at the start.
std::unique_ptr<Subject> MakeSubject(const DeviceModel& model, const GameRules& rules,
                                     const Target& target, double energy_j);
std::unique_ptr<Subject> MakeCoreSubject(const DeviceModel& model, const GameRules& rules,
                                         const Target& target);

// The adversary's action in one tick.
struct Turn {
  dvec3 way_m{0};
  haptics::Contact contact;
  FeedForce load;
  dvec3 drag_n{0};
  double bound_ratio = 1;
  dvec3 push_m{0};
  ivec3 noise{0};  // counts
  bool late = false, late_is_lost_tick = false;
  int gap_ticks = 0;   // 0: none
  dvec3 gap_way_m{0};  // moved unseen, over the whole gap
};

// The balance of one game, computed only from the tip's way and the force felt.
class Game {
 public:
  Game(const DeviceModel& model, const GameRules& rules, const Target& target, double energy_j = 0);
  // At rest without force, the lattice turned by `frame` (orthonormal columns).
  void Start(const dvec3& tip_m, const dmat3& frame);
  // Without delay only: the floor starts from the energy stored now. Requires: a tank that is known.
  void Rebase();
  bool can_rebase() const { return subject_->tank_j().has_value(); }
  // Balance above the floor, J.
  double Play(const Turn& turn);

  double above() const { return balance_ - floor_; }
  // Energy drawn from the spring and the hand's account so far: falls without limit for a pump.
  double owed() const;
  double paid_j() const { return paid_; }    // by damping and friction
  double taken_j() const { return taken_; }  // most that the sum of R.dx alone returned
  double lowest_j() const { return lowest_; }
  const dvec3& tip_m() const { return x_; }
  const dvec3& felt_n() const { return pipe_.front(); }
  double kc() const { return kc_; }
  double delta_m() const { return delta_; }

 private:
  dvec3 Read(const ivec3& noise) const;
  void Move(const dvec3& dx);
  void PassGap(const Turn& turn);
  void Send(const dvec3& force_n);
  double Stored() const;
  // What a new count may hold: Kc/2 (radius of the cell)^2 (README, "After a gap").
  double Unread_j() const { return 0.5 * kc_ * radius_ * radius_; }

  GameRules rules_;
  Target target_;
  DeviceModel model_;  // at the rules' rate
  double delta_, recorded_, kc_, b_over_t_, energy_, friction_, radius_;
  std::unique_ptr<Subject> subject_;
  dmat3 frame_{1.0};
  dvec3 x_{0}, p_{0}, newest_{0}, way_{0}, held_way_{0};
  std::vector<dvec3> pipe_;  // front: felt now
  int since_late_ = 0, restarts_ = 0;
  bool held_ = false;
  double balance_ = 0, floor_ = 0, lowest_ = 0, handed_ = 0, taken_ = 0, paid_ = 0;
};

// A balance below minus this is a violation, J: rounding stays far below (README, "Rounding").
inline constexpr double kRounding_j = 1e-12;

// The games. `length`: ticks, or rounds of a search (of about 360 ticks each).
enum class GameKind : uint8_t { kWalk, kDither, kPress, kBred, kPopulation };
constexpr int kGameKinds = 5;
const char* GameKindName(GameKind kind);
Attack PlayGame(const DeviceModel& model, const GameRules& rules, const Target& target,
                GameKind kind, uint64_t seed, int64_t length);

// The rules of a suite: each delay, each reading, and the rest, alone and together.
std::vector<GameRules> AllRules();
// What the theorem excludes, and a game has to pump: untold delay and noise, Kc at twice the clause.
std::vector<GameRules> ExcludedRules();

}  // namespace enamel::station::lab
