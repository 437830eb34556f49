#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/fidelity/plant.h"
#include "common/haptics/coupling.h"
#include "common/haptics/guard.h"
#include "station/lab/suites/findings.h"

// Games against the theorem of common/haptics/README.md ("Why it is passive"). The adversary is
// more than the hand: delay, noise, turned lattices, bounds that jump, gaps, late ticks. Each game
// is played at the least damping and friction that its own clause allows, so that no reserve of the
// device can hide a mistake. SI units. Thread safety: one Game per thread.
namespace enamel::station::lab {

using fidelity::CellMiddle;
using fidelity::Random;

// The adversary's means besides moving the tip and choosing B every tick.
struct GameRules {
  enum class Late : uint8_t { kNone, kCovered, kLeak };

  int delay_ticks = 0;
  int noise_counts = 0;        // each reading is off by up to that many counts per axis
  bool lattice = false;        // cells are those of joints turned any way
  bool driver_rounds = false;  // and the driver rounds the result to its own cells of the same edge
  bool bounds = false;         // the bound on the force jumps every tick, to 0 and from 0
  bool gaps = false;           // the force stops, the tip moves unseen, the spring continues
  // Occasionally a force is felt for two ticks. Either the device missed a new force or the
  // coupling a tick (covered by the clause of one more tick of delay), or it lasts only a tick,
  // without delay, and the leak that README.md names is added to the balance.
  Late late = Late::kNone;
  // Delay unknown to the guard and the clause: the theorem excludes it, and the games must find it.
  int undeclared_ticks = 0;

  int clause_ticks() const { return delay_ticks + (late == Late::kCovered ? 1 : 0); }
  haptics::TipCell Cell(double resolution_m) const;
  std::string Name() const;
};

// The target of the attack: a coupling, or a bare spring whose rest point the adversary moves with
// only the guard in between.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual void Reset(const dvec3& tip_m) = 0;
  virtual void Resume(const dvec3& tip_m) = 0;
  // Resisting force to send. `push_m`: the adversary's wish for the rest point; a coupling ignores
  // it.
  virtual dvec3 Tick(const dvec3& tip_m, double bound_ratio, const haptics::Contact& contact,
                     const dvec3& push_m) = 0;
  virtual double tank_j() const { return 0; }
};

// subjects.cpp. nullopt: the bare spring, with `energy_j` in its tank at the start.
std::unique_ptr<Subject> MakeSubject(const DeviceModel& model, const GameRules& rules,
                                     std::optional<haptics::LawKind> law, double energy_j);
// Largest stiffness the rules' clause lets this device use, at most the profile's, N/m.
double ClauseStiffness(const DeviceModel& model, const GameRules& rules);
// Whether the theorem covers this law under these rules.
bool Covered(std::optional<haptics::LawKind> law, const GameRules& rules);

// The adversary's action in one tick.
struct Turn {
  dvec3 way_m{0};
  haptics::Contact contact;
  double bound_ratio = 1;
  dvec3 push_m{0};
  ivec3 noise{0};  // counts
  bool late = false, late_is_lost_tick = false;
  bool gap = false;
  dvec3 gap_way_m{0};  // moved unseen
};

// The balance of one game, computed only from the tip's way and the force felt.
class Game {
 public:
  Game(const DeviceModel& model, const GameRules& rules, std::optional<haptics::LawKind> law,
       double energy_j = 0);
  // At rest without force, the lattice turned by `frame` (orthonormal columns).
  void Start(const dvec3& tip_m, const dmat3& frame);
  // Without delay only: the floor starts from the energy stored now.
  void Rebase();
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
  double Stored() const;

  GameRules rules_;
  std::optional<haptics::LawKind> law_;
  const DeviceModel& model_;
  double delta_, kc_, b_over_t_, energy_;
  dvec3 friction_;
  double radius_;
  std::unique_ptr<Subject> subject_;
  dmat3 frame_{1.0};
  dvec3 x_{0}, p_{0}, newest_{0}, way_{0}, held_way_{0};
  std::vector<dvec3> pipe_;  // front: felt now
  int since_late_ = 0;
  bool held_ = false;
  double balance_ = 0, floor_ = 0, lowest_ = 0, handed_ = 0, taken_ = 0, paid_ = 0;
};

// A balance below minus this is a violation, J: rounding stays far below (README, "Rounding").
inline constexpr double kRounding_j = 1e-12;

// The games. `length`: ticks, or rounds of a search (of about 360 ticks each).
enum class GameKind : uint8_t { kWalk, kDither, kPress, kBred, kPopulation };
constexpr int kGameKinds = 5;
const char* GameKindName(GameKind kind);
Attack PlayGame(const DeviceModel& model, const GameRules& rules,
                std::optional<haptics::LawKind> law, GameKind kind, uint64_t seed, int64_t length);

// The rules of a suite: each delay, each reading, and the rest, alone and together.
std::vector<GameRules> AllRules();

}  // namespace enamel::station::lab
