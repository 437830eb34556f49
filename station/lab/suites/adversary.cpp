#include "station/lab/suites/adversary.h"

#include <algorithm>

#include "station/lab/suites/attacks.h"

namespace enamel::station::lab {
namespace {

using haptics::LawKind;

}  // namespace

Game::Game(const DeviceModel& m, const GameRules& rules, std::optional<LawKind> law, double energy)
    : rules_(rules),
      law_(law),
      model_(m),
      delta_(m.resolution_m),
      kc_(ClauseStiffness(m, rules)),
      energy_(energy) {
  // b/T at equality in the clause, Kc = 2 b/((d + 1)^2 T): the device may have more, which would
  // only help.
  double ticks = rules.clause_ticks() + 1;
  b_over_t_ = 0.5 * kc_ * ticks * ticks;
  haptics::TipCell cell = rules.Cell(delta_);
  friction_ = cell.Friction(kc_);
  radius_ = cell.Radius();
  pipe_.assign(static_cast<size_t>(rules.delay_ticks + rules.undeclared_ticks) + 1, dvec3(0));
  Start(dvec3(0), dmat3(1.0));
}

dvec3 Game::Read(const ivec3& noise) const {
  dvec3 shift = dvec3(noise) * delta_;
  if (!rules_.lattice) return CellMiddle(x_, delta_) + shift;
  // Rounded in the joints' axes, noise in their counts, then turned back.
  dvec3 p = frame_ * (CellMiddle(glm::transpose(frame_) * x_, delta_) + shift);
  return rules_.driver_rounds ? CellMiddle(p, delta_) : p;
}

void Game::Start(const dvec3& tip, const dmat3& frame) {
  subject_ = MakeSubject(model_, rules_, law_, energy_);
  frame_ = frame;
  x_ = tip;
  p_ = Read(ivec3(0));
  subject_->Reset(p_);
  std::fill(pipe_.begin(), pipe_.end(), dvec3(0));
  newest_ = held_way_ = dvec3(0);
  since_late_ = 0;
  held_ = false;
  Rebase();
}

// The rest point is p less the newest force over Kc.
double Game::Stored() const {
  dvec3 stretch = x_ - p_ + newest_ / kc_;
  return 0.5 * kc_ * Dot(stretch, stretch);
}

void Game::Rebase() {
  floor_ = -Stored() - subject_->tank_j();
  balance_ = lowest_ = handed_ = taken_ = paid_ = 0;
}

double Game::owed() const { return balance_ - Stored() - subject_->tank_j(); }

double Game::Play(const Turn& turn) {
  const dvec3& dx = turn.way_m;
  // The force felt during this motion was computed delay ticks ago.
  double work = Dot(pipe_.front(), dx);
  double paid = b_over_t_ * Dot(dx, dx) + Dot(friction_, glm::abs(dx));
  balance_ += work + paid;
  paid_ += paid;
  handed_ += work;
  // Larger than the energy stored at the start: `floor_` is minus that.
  taken_ = std::max(taken_, -handed_ + floor_);
  x_ += dx;
  if (held_) {
    double leak = 0.5 * kc_ - 0.5 * b_over_t_;  // Kc/2 - b/T_hold, T_hold = 2 T
    dvec3 way = held_way_ + dx;
    if (rules_.late == GameRules::Late::kLeak && leak > 0) balance_ += leak * Dot(way, way);
  }
  lowest_ = std::min(lowest_, above());
  // A late tick must be over before the next one.
  ++since_late_;
  bool late =
      turn.late && rules_.late != GameRules::Late::kNone && since_late_ > rules_.delay_ticks + 3;
  bool lost = late && (turn.late_is_lost_tick || rules_.late == GameRules::Late::kLeak);
  if (late) since_late_ = 0;
  held_ = lost;
  held_way_ = dx;
  if (turn.gap && rules_.gaps) {
    // The force stops, the tip moves on; then the spring starts again.
    std::fill(pipe_.begin(), pipe_.end(), dvec3(0));
    newest_ = dvec3(0);
    x_ += turn.gap_way_m;
    p_ = Read(turn.noise);
    subject_->Resume(p_);
    // A new start may hold unpaid energy of Kc/2 (radius of the cell)^2 (README, "After a gap").
    floor_ -= 0.5 * kc_ * radius_ * radius_;
    lost = held_ = false;
  }
  dvec3 felt = pipe_.front();
  if (!lost) {
    p_ = Read(turn.noise);
    newest_ = subject_->Tick(p_, turn.bound_ratio, turn.contact, turn.push_m);
  }
  pipe_.erase(pipe_.begin());
  pipe_.push_back(newest_);
  // The coupling has stepped; the device missed the new force and holds the last one.
  if (late && !lost) pipe_.front() = felt;
  return above();
}

const char* GameKindName(GameKind kind) {
  switch (kind) {
    case GameKind::kWalk:
      return "random walk";
    case GameKind::kDither:
      return "dither scan";
    case GameKind::kPress:
      return "press and let go";
    case GameKind::kBred:
      return "bred";
    case GameKind::kPopulation:
      return "bred population";
  }
  return "";
}

Attack PlayGame(const DeviceModel& m, const GameRules& rules, std::optional<LawKind> law,
                GameKind kind, uint64_t seed, int64_t length) {
  Attack a;
  a.law = law ? haptics::FindLaw(*law)->name : "guard alone";
  a.kind = rules.Name();
  a.made = GameKindName(kind);
  a.profile = m.name;
  a.seed = seed;
  a.length = length;
  a.proved = Covered(law, rules);
  Random r(seed);
  // An empty tank, or one as full as a declared start may make it.
  double full = 0.125 * m.peak_force_n * m.peak_force_n / ClauseStiffness(m, rules);
  Game game(m, rules, law, r.Below(2) ? full * r.LogBetween(1e-6, 1) : 0);
  switch (kind) {
    case GameKind::kWalk:
      PlayWalk(game, rules, r, length, &a);
      break;
    case GameKind::kDither:
      PlayDither(game, rules, r, length, &a);
      break;
    case GameKind::kPress:
      PlayPress(game, rules, r, length, &a);
      break;
    case GameKind::kBred:
      PlayBred(game, rules, r, length, &a);
      break;
    case GameKind::kPopulation:
      PlayPopulation(game, rules, r, length, &a);
      break;
  }
  return a;
}

}  // namespace enamel::station::lab
