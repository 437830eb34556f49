#include "station/lab/suites/adversary.h"

#include <algorithm>

#include "common/scene/cell.h"
#include "station/lab/suites/attacks.h"

namespace enamel::station::lab {

Game::Game(const DeviceModel& m, const GameRules& rules, const Target& target, double energy)
    : rules_(rules),
      target_(target),
      model_(AtRate(m, rules.rate_hz, rules.rate_hz != m.rate_hz)),
      delta_(m.resolution_m),
      kc_(ClauseStiffness(m, rules)),
      energy_(energy) {
  const scene::DeviceProfile profile = rules.ProfileOf(m);
  recorded_ = profile.cell->count_nm * 1e-9;
  // b/T at equality in the clause, Kc = 2 b/((d + 1)^2 T), and c = Kc S: the device may have more, which
  // would only help.
  const double ticks = rules.clause_ticks() + 1, clause_kc = kc_ / rules.over_clause;
  b_over_t_ = 0.5 * clause_kc * ticks * ticks;
  friction_ = ClauseFriction(m, rules, target);
  radius_ = CellUnder(m, rules).Radius();
  pipe_.assign(static_cast<size_t>(rules.delay_ticks + rules.untold_ticks) + 1, dvec3(0));
  Start(dvec3(0), dmat3(1.0));
}

dvec3 Game::Read(const ivec3& noise) const {
  dvec3 shift = dvec3(noise) * delta_;
  if (!rules_.lattice) return CellMiddle(x_, delta_) + shift;
  // Rounded in the joints' axes, noise in their counts, then turned back and recorded.
  return CellMiddle(frame_ * (CellMiddle(glm::transpose(frame_) * x_, delta_) + shift), recorded_);
}

void Game::Start(const dvec3& tip, const dmat3& frame) {
  subject_ = MakeSubject(model_, rules_, target_, energy_);
  frame_ = frame;
  x_ = tip;
  p_ = Read(ivec3(0));
  subject_->Start(p_);
  std::fill(pipe_.begin(), pipe_.end(), dvec3(0));
  newest_ = held_way_ = dvec3(0);
  since_late_ = restarts_ = 0;
  held_ = false;
  Rebase();
}

// The rest point is p less the newest force over Kc.
double Game::Stored() const {
  if (const auto stored = subject_->stored_j(x_)) return *stored;
  dvec3 stretch = x_ - p_ + newest_ / kc_;
  return 0.5 * kc_ * Dot(stretch, stretch);
}

void Game::Rebase() {
  const std::optional<double> tank = subject_->tank_j();
  floor_ = tank ? -Stored() - *tank : 0;
  balance_ = lowest_ = handed_ = taken_ = paid_ = 0;
}

double Game::owed() const { return balance_ - Stored() - subject_->tank_j().value_or(0); }

// The force felt during this motion was computed delay ticks ago. Joints rub along their own axes.
void Game::Move(const dvec3& dx) {
  const dvec3 rubbed = glm::abs(rules_.lattice ? glm::transpose(frame_) * dx : dx);
  const double work = Dot(pipe_.front(), dx);
  const double paid = b_over_t_ * Dot(dx, dx) + friction_ * (rubbed.x + rubbed.y + rubbed.z);
  balance_ += work + paid;
  paid_ += paid;
  handed_ += work;
  // Larger than the energy stored at the start: `floor_` is minus that.
  taken_ = std::max(taken_, -handed_ + floor_);
  x_ += dx;
  lowest_ = std::min(lowest_, above());
}

void Game::Send(const dvec3& force) {
  pipe_.erase(pipe_.begin());
  pipe_.push_back(force);
}

// The loop sends 0 in every tick that it does not step; forces under way are still felt.
void Game::PassGap(const Turn& turn) {
  for (int i = 0; i < turn.gap_ticks; ++i) {
    Send(dvec3(0));
    Move(turn.gap_way_m / static_cast<double>(turn.gap_ticks));
  }
}

double Game::Play(const Turn& turn) {
  Move(turn.way_m);
  if (held_) {
    double leak = 0.5 * kc_ - 0.5 * b_over_t_;  // Kc/2 - b/T_hold, T_hold = 2 T
    dvec3 way = held_way_ + turn.way_m;
    if (rules_.late == GameRules::Late::kLeak && leak > 0) balance_ += leak * Dot(way, way);
  }
  const bool gap = turn.gap_ticks > 0 && rules_.gaps;
  if (gap) PassGap(turn);
  lowest_ = std::min(lowest_, above());
  // A late tick must be over before the next one.
  ++since_late_;
  const bool late = !gap && turn.late && rules_.late != GameRules::Late::kNone &&
                    since_late_ > rules_.delay_ticks + 3;
  const bool lost = late && (turn.late_is_lost_tick || rules_.late == GameRules::Late::kLeak);
  if (late) since_late_ = 0;
  held_ = lost;
  held_way_ = turn.way_m;
  const dvec3 felt = pipe_.front();
  if (!lost) {
    p_ = Read(turn.noise);
    newest_ = subject_->Step({p_, gap ? turn.gap_ticks : 0, turn.bound_ratio, turn.contact,
                              turn.load, turn.drag_n, turn.push_m});
    // Each may hold unpaid energy of the cell's size (README, "After a gap").
    floor_ -= Unread_j() * (subject_->restarts() - restarts_);
    restarts_ = subject_->restarts();
  }
  Send(newest_);
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

Attack PlayGame(const DeviceModel& m, const GameRules& rules, const Target& target, GameKind kind,
                uint64_t seed, int64_t length) {
  Attack a;
  a.law = target.Name();
  a.kind = rules.Name();
  a.made = GameKindName(kind);
  a.profile = m.name;
  a.seed = seed;
  a.length = length;
  a.proved = Covered(target, rules);
  Random r(seed);
  // An empty tank, or one as full as a declared start may make it.
  double full = 0.125 * m.peak_force_n * m.peak_force_n / ClauseStiffness(m, rules);
  Game game(m, rules, target, r.Below(2) ? full * r.LogBetween(1e-6, 1) : 0);
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
