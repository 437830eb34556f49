#include "station/lab/suites/adversary.h"

#include <algorithm>
#include <cmath>

#include "common/haptics/uniform_material.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

using haptics::Contact;
using haptics::LawKind;

class CouplingSubject final : public Subject {
 public:
  CouplingSubject(const DeviceModel& m, const GameRules& rules, LawKind law)
      : coupling_(Params(m, rules, law)) {}
  void Reset(const dvec3& tip) override { coupling_.Reset(tip); }
  void Resume(const dvec3& tip) override {
    if (!coupling_.Resume(tip, material_)) coupling_.Reset(tip);
  }
  dvec3 Tick(const dvec3& tip, double bound_ratio, const Contact& contact, const dvec3&) override {
    material_.contact = contact;
    haptics::CouplingOutput out = coupling_.Tick(tip, bound_ratio, material_);
    tank_j_ = out.tank_j;
    // The coupling gives the force on the operator; the theorem is about the resisting one.
    return -out.force_sent_n;
  }
  double tank_j() const override { return tank_j_; }

 private:
  static haptics::CouplingParams Params(const DeviceModel& m, const GameRules& rules, LawKind law) {
    haptics::CouplingParams p;
    p.law.kind = law;
    p.law.kc_n_per_m = ClauseStiffness(m, rules);
    p.law.tick_s = m.tick_s();
    p.peak_force_n = p.law.peak_force_n = m.peak_force_n;
    haptics::TipCell cell = rules.Cell(m.resolution_m);
    if (law == LawKind::kTankMaxwell) {
      p.law.resolution_m = dvec3(m.resolution_m);
      p.cell = cell;
      // The tank law gets exactly the delay of the rules, for which it is proved.
      p.delay_ticks = rules.clause_ticks();
    } else {
      // The older guard only handles boxes: one around the cell, whatever its shape.
      p.law.resolution_m = (cell.half_m + cell.ball_m) * 2.0;
    }
    return p;
  }
  haptics::Coupling coupling_;
  haptics::UniformMaterial material_;
  double tank_j_ = 0;
};

// The guard without a law. The adversary requests what a law could do at worst, so a pump found
// here exists in every law that moves its rest point by guarded steps.
class GuardedSpring final : public Subject {
 public:
  GuardedSpring(const DeviceModel& m, const GameRules& rules, double energy)
      : kc_(ClauseStiffness(m, rules)), tick_(m.tick_s()), peak_(m.peak_force_n) {
    params_.kc_n_per_m = kc_;
    params_.cell = rules.Cell(m.resolution_m);
    params_.delay_ticks = rules.clause_ticks();
    tank_.energy_j = energy;
    // The spring's energy at half the peak force, (F/2)^2/(2 Kc): enough to be worth stealing.
    tank_.cap_j = 0.125 * peak_ * peak_ / kc_;
    tank_.inflow_share = 0.3;
  }
  void Reset(const dvec3& tip) override {
    tip_ = rest_ = tip;
    share_ = 1;
    sent_ = dvec3(0);
  }
  void Resume(const dvec3& tip) override {
    dvec3 e = tip - rest_;
    Reset(tip);
    params_.kc_n_per_m = kc_;
    tank_.BeginTick();
    resumed_ = true;  // the next tick's steps are of the same tick
    rest_ -= e * haptics::ResumedShare(params_, e, 0, tank_);
  }
  dvec3 Tick(const dvec3& tip, double bound_ratio, const Contact& contact,
             const dvec3& push) override {
    // From quantised positions, hence wrong by a cell. The proof does not use it; it bounds the
    // inflow.
    double work = Dot(sent_, tip - tip_);
    tip_ = tip;
    if (!resumed_) tank_.BeginTick();
    resumed_ = false;
    Move(push, work);
    dvec3 e = tip_ - rest_;
    Sym3 b = contact.damping_n_s_per_m;
    // The implicit Maxwell step (B + Kc T)^-1 Kc T e: bounded for every B, however small.
    dvec3 w = e - b * SolveShifted(b, kc_ * tick_, e);
    double into = Dot(w, contact.wall_normal);
    if (into > 0) w -= contact.wall_normal * into;
    Move(w, work);
    double bound = peak_ * bound_ratio;
    e = tip_ - rest_;
    // As in the coupling: the rest point yields first, the rest is a share of the stiffness.
    double force = kc_ * std::sqrt(Dot(e, e));
    if (force > bound) Move(e * (1 - bound / force), work);
    params_.kc_n_per_m = kc_;
    share_ = haptics::StiffnessShare(params_, tip_ - rest_, bound, share_, tank_);
    sent_ = (tip_ - rest_) * (kc_ * share_);
    return sent_;
  }
  double tank_j() const override { return tank_.energy_j; }

 private:
  void Move(const dvec3& w, double work) {
    params_.kc_n_per_m = kc_ * share_;
    rest_ += w * haptics::GuardedStep(params_, tip_ - rest_, w, work, tank_);
  }
  double kc_, tick_, peak_;
  haptics::GuardParams params_;
  haptics::Tank tank_;
  dvec3 tip_{0}, rest_{0}, sent_{0};
  double share_ = 1;
  bool resumed_ = false;
};

dmat3 RandomFrame(Random& r) {
  dvec3 a = r.Direction(), b = r.Direction();
  b = glm::normalize(b - a * Dot(a, b));
  return {a, b, glm::cross(a, b)};
}

void RandomContact(Random& r, Contact* contact) {
  Sym3 b;
  // Directions that resist: none in air, three in solid tissue.
  int rank = r.Below(4);
  for (int i = 0; i < rank; ++i) b += Sym3::Outer(r.Direction(), r.LogBetween(1, 1e6));
  contact->damping_n_s_per_m = b;
  contact->engaged = rank > 0;
  contact->wall_normal = r.Below(16) == 0 ? r.Direction() : dvec3(0);
  contact->clearance_m = rank == 0 ? 1 : 0;
}

// Rounding stays far below (README, "Rounding").
constexpr double kRounding_j = 1e-12;

void Count(const Game& game, double above, Attack* attack) {
  if (above < -kRounding_j) ++attack->violations;
  attack->worst_j = std::min(attack->worst_j, above);
  attack->extracted_j = std::max(attack->extracted_j, game.taken_j());
  ++attack->ticks;
}

void PlayWalk(Game& game, const GameRules& rules, Random& r, int64_t ticks, Attack* attack) {
  Turn turn;
  dvec3 v(0);
  double pace = 1, memory = 0;
  int dither = 0, steady = 1;
  for (int64_t tick = 0; tick < ticks; ++tick) {
    // An occasional new start: a pump would show within some periods, and other periods get their
    // turn.
    if (tick % 1500 == 0) {
      pace = game.delta_m() * r.LogBetween(1e-3, 30);
      memory = r.Uniform();
      dither = r.Below(3) == 0 ? 1 + r.Below(rules.delay_ticks + 3) : 0;
      steady = r.Below(2) ? 1 : 2 + r.Below(200);
      v = r.Direction() * pace;
      turn = Turn{};
      game.Start(dvec3(r.Signed(), r.Signed(), r.Signed()) * 1e-4, RandomFrame(r));
      // The floor of a loaded start is known only if no force is still on its way.
      if (rules.delay_ticks == 0 && rules.late == GameRules::Late::kNone && r.Below(2)) {
        turn.contact.damping_n_s_per_m = Sym3::Isotropic(1e8);
        turn.contact.engaged = true;
        for (int i = 0; i < 20; ++i) {
          turn.way_m = r.Direction() * (game.delta_m() * r.Between(0, 20));
          game.Play(turn);
        }
        game.Rebase();
      }
    }
    if (tick % steady == 0) RandomContact(r, &turn.contact);
    if (dither > 0) {
      if (tick % dither == 0) v = -v;
      if (r.Below(2)) {  // wall or air
        turn.contact.damping_n_s_per_m = Sym3::Isotropic(r.Below(2) ? 1e9 : 0.0);
        turn.contact.wall_normal = dvec3(0);
        turn.contact.engaged = turn.contact.damping_n_s_per_m.xx > 0;
        turn.contact.clearance_m = turn.contact.engaged ? 0 : 1;
      }
      turn.way_m = v;
    } else {
      v = v * memory + r.Direction() * (pace * r.Uniform());
      if (r.Below(2))
        v -= game.felt_n() * (pace * r.Uniform() / (glm::length(game.felt_n()) + 1e-9));
      turn.way_m = v;
    }
    turn.push_m =
        steady == 1 && r.Below(2) ? r.Direction() * (pace * r.LogBetween(0.01, 30)) : dvec3(0);
    if (rules.bounds) {
      int draw = r.Below(4);
      turn.bound_ratio = draw == 0 ? 0 : draw == 1 ? 1 : r.LogBetween(1e-4, 1);
    }
    for (int i = 0; i < 3; ++i)
      turn.noise[i] = r.Below(2 * rules.noise_counts + 1) - rules.noise_counts;
    turn.late = r.Below(6) == 0;
    turn.late_is_lost_tick = r.Below(2);
    turn.gap = r.Below(40) == 0;
    turn.gap_way_m = r.Direction() * (pace * r.LogBetween(0.1, 100));
    double above = game.Play(turn);
    Count(game, above, attack);
  }
}

// The tip dithers across an edge of its cell while wall and air alternate in every pattern; all of
// them if they are few, else drawn.
void PlayDither(Game& game, const GameRules& rules, Random& r, int64_t ticks, Attack* attack) {
  constexpr std::array kReaches = {0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.4};
  int64_t played = 0;
  for (uint64_t round = 0; played < ticks; ++round) {
    int half = rules.delay_ticks + 1, period = 2 * half;
    // First every pattern of wall and air over one period, each with every reach; then drawn ones.
    bool known = round < kReaches.size() << period;
    if (!known) {
      half = 1 + r.Below(rules.delay_ticks + 3);
      period = 2 * half;
    }
    uint64_t air = known ? round / kReaches.size() : r.Next();
    double reach =
        game.delta_m() * (known ? kReaches[round % kReaches.size()] : r.LogBetween(1e-3, 1));
    // Across the edges of one, two or three axes at once.
    dvec3 way(1, 0, 0);
    if (!known) way = dvec3(r.Signed(), r.Below(2) * r.Signed(), r.Below(2) * r.Signed());
    Turn turn;
    game.Start(way * -reach, known ? dmat3(1.0) : RandomFrame(r));
    dvec3 shake = known ? dvec3(0) : r.Direction() * (reach * r.Uniform());
    for (int k = 0; k < 16 * period && played < ticks; ++k, ++played) {
      bool free = air >> (k % period) & 1;
      turn.contact.damping_n_s_per_m = Sym3::Isotropic(free ? 0 : 1e12);
      turn.contact.engaged = !free;
      turn.contact.clearance_m = free ? 1 : 0;
      turn.way_m =
          way * (k % period < half ? reach : -reach) + shake * double(k % 3 - 1) - game.tip_m();
      if (rules.noise_counts > 0 && !known) {
        for (int i = 0; i < 3; ++i)
          turn.noise[i] = r.Below(2 * rules.noise_counts + 1) - rules.noise_counts;
      }
      if (rules.bounds) turn.bound_ratio = (air >> (16 + k % period)) & 1 ? 1 : 0;
      turn.late = turn.late_is_lost_tick = (air >> (32 + k % period)) & 1;
      turn.gap = rules.gaps && k % period == 0 && (air >> 48 & 3) == 0;
      turn.gap_way_m = way * reach;
      double above = game.Play(turn);
      Count(game, above, attack);
    }
  }
}

// Presses into something hard, lets go, comes back: with the bound at 0 on the way in and up on the
// way out, and with a jerk outwards in the tick whose force stops before the tip returns unseen.
void PlayPress(Game& game, const GameRules& rules, Random& r, int64_t ticks, Attack* attack) {
  int64_t played = 0;
  while (played < ticks) {
    game.Start(r.Direction() * (game.delta_m() * r.Uniform()), RandomFrame(r));
    dvec3 in = r.Direction() * (game.delta_m() * r.LogBetween(0.1, 30));
    Turn turn;
    // A wall that blocks the way in, or material too hard to move in.
    bool wall = r.Below(2), soft_out = r.Below(3) == 0, bound_in = r.Below(3) == 0;
    double jerk = r.LogBetween(0.1, 50), back = jerk * r.Between(-0.5, 1.5);
    int press = 1 + r.Below(20), jerks = r.Below(3);
    auto Play = [&](const dvec3& way, double bound, bool free) {
      turn.way_m = way;
      turn.bound_ratio = rules.bounds ? bound : 1;
      turn.contact = Contact{};
      turn.contact.engaged = !free;
      if (wall && !free) turn.contact.wall_normal = glm::normalize(in);
      turn.contact.damping_n_s_per_m = Sym3::Isotropic(free ? 0 : 1e12);
      turn.contact.clearance_m = free ? 1 : 0;
      turn.late = r.Below(6) == 0;
      turn.late_is_lost_tick = r.Below(2);
      for (int i = 0; i < 3; ++i)
        turn.noise[i] = r.Below(2 * rules.noise_counts + 1) - rules.noise_counts;
      double above = game.Play(turn);
      Count(game, above, attack);
      ++played;
    };
    for (int cycle = 0; cycle < 4; ++cycle) {
      for (int k = 0; k < press; ++k) Play(in, bound_in ? 1 : 0, false);
      for (int k = 0; k < jerks; ++k) {
        turn.gap = rules.gaps;
        turn.gap_way_m = in * back;
        Play(-in * jerk, 1, false);
        turn.gap = false;
      }
      for (int k = 0; k < press; ++k) Play(-in, 1, soft_out);
    }
  }
}

// The tick, bred: the tip's position, B, bound, push, noise, late, gap. Positions are in cells
// times ten to the last gene.
class Strategy {
 public:
  static constexpr size_t kTicks = 12, kGenes = 16, kSize = kTicks * kGenes + 2;
  std::vector<double> g = std::vector<double>(kSize, 0.0);

  static Strategy Draw(Random& r) {
    Strategy s;
    for (double& gene : s.g) gene = r.Normal();
    if (r.Below(2)) {
      // Hard material all the way and no pushes, to begin with: the spring alone.
      for (size_t tick = 0; tick < kTicks; ++tick) {
        double* q = &s.g[tick * kGenes];
        q[3] = 2;
        q[4] = q[8] = -1;
      }
    }
    return s;
  }
  size_t period() const {
    double share = 1 / (1 + std::exp(-g[kSize - 2]));
    return 2 + static_cast<size_t>(std::lround((kTicks - 2) * share));
  }
  Turn At(size_t tick, const Game& game, const GameRules& rules) const {
    const double* q = &g[(tick % period()) * kGenes];
    // A thirtieth of a cell to thirty cells.
    double scale = game.delta_m() * std::pow(10, std::clamp(g[kSize - 1], -1.5, 1.5));
    Turn t;
    t.way_m = dvec3(q[0], q[1], q[2]) * scale - game.tip_m();
    // 0.05 to 7e10 N s/m; a gene of 0 is 3000.
    double b = std::exp(std::clamp(8 + 8 * q[3], -3.0, 25.0));
    Sym3 normal_only = Sym3::Outer(glm::normalize(dvec3(q[5], q[6], 1 + q[7])), b);
    t.contact.engaged = q[3] > -1.4;
    t.contact.damping_n_s_per_m = !t.contact.engaged ? Sym3{}
                                  : q[4] > 0.5       ? normal_only
                                                     : Sym3::Isotropic(b);
    t.contact.clearance_m = t.contact.engaged ? 0 : 1;
    if (q[8] > 0) t.push_m = dvec3(q[5], q[6], q[7]) * scale;
    if (rules.bounds) t.bound_ratio = q[9] > 1 ? 0 : q[9] > 0 ? 1 : std::exp(3 * q[9]);
    for (int i = 0; i < 3; ++i) {
      double counts = std::clamp(q[10 + i], -1.0, 1.0) * (rules.noise_counts + 0.49);
      t.noise[i] = static_cast<int>(std::lround(counts));
    }
    t.late = q[13] > 1;
    t.late_is_lost_tick = q[14] > 0;
    t.gap = rules.gaps && q[15] > 1.5;
    t.gap_way_m = dvec3(q[10], q[11], q[12]) * scale;
    return t;
  }
};

// Energy drawn by further periods, as a share of the pay of damping and friction in them: breeding
// for the energy itself would give a tip that rests. Every tick counts for the floor.
double PlayStrategy(Game& game, const GameRules& rules, const Strategy& s, const dmat3& frame,
                    Attack* attack) {
  constexpr size_t kPeriods = 30;
  game.Start(s.At(0, game, rules).way_m + game.tip_m(), frame);
  double settled = 0, paid = 0;
  size_t ticks = kPeriods * s.period();
  for (size_t k = 1; k <= ticks; ++k) {
    // The first half is the run-up: only a repeating motion's gain counts.
    if (k == ticks / 2) {
      settled = game.owed();
      paid = game.paid_j();
    }
    double above = game.Play(s.At(k, game, rules));
    Count(game, above, attack);
  }
  return (settled - game.owed()) / (game.paid_j() - paid + 1e-15);
}

// One parent, one child, the one-fifth rule; half of the children differ in a tick only.
void PlayBred(Game& game, const GameRules& rules, Random& r, int64_t rounds, Attack* attack) {
  dmat3 frame = RandomFrame(r);
  Strategy best = Strategy::Draw(r);
  double most = PlayStrategy(game, rules, best, frame, attack), size = 0.5;
  for (int64_t round = 1; round < rounds; ++round) {
    Strategy next = best;
    size_t only = static_cast<size_t>(r.Below(2 * static_cast<int>(Strategy::kTicks)));
    for (size_t i = 0; i < Strategy::kSize; ++i) {
      bool chosen = only < Strategy::kTicks ? i / Strategy::kGenes == only : r.Below(4) == 0;
      if (chosen) next.g[i] += size * r.Normal();
    }
    double drawn = PlayStrategy(game, rules, next, frame, attack);
    // 1.5 up and 0.97 down balance at about one success in fourteen: slow enough not to collapse
    // on the long plateaus of these games.
    size = std::clamp(size * (drawn > most ? 1.5 : 0.97), 0.003, 3.0);
    // Equally good children are accepted too: the search drifts along plateaus, where most of its
    // time goes.
    if (drawn >= most) {
      most = drawn;
      best = next;
    }
  }
}

// A small population whose spread per gene follows its best third (a separable evolution strategy).
void PlayPopulation(Game& game, const GameRules& rules, Random& r, int64_t rounds, Attack* attack) {
  constexpr size_t kMany = 12, kBest = 4;
  dmat3 frame = RandomFrame(r);
  Strategy mean = Strategy::Draw(r);
  std::vector<double> spread(Strategy::kSize, 0.7);
  for (int64_t round = 0; round + static_cast<int64_t>(kMany) <= rounds;
       round += static_cast<int64_t>(kMany)) {
    std::vector<std::pair<double, Strategy>> many(kMany);
    for (auto& [drawn, s] : many) {
      s = mean;
      for (size_t i = 0; i < Strategy::kSize; ++i) s.g[i] += spread[i] * r.Normal();
      drawn = PlayStrategy(game, rules, s, frame, attack);
    }
    std::stable_sort(many.begin(), many.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    for (size_t i = 0; i < Strategy::kSize; ++i) {
      double middle = 0, wide = 0;
      for (size_t k = 0; k < kBest; ++k) {
        double off = many[k].second.g[i] - mean.g[i];
        middle += off / kBest;
        wide += off * off / kBest;
      }
      mean.g[i] += middle;
      spread[i] = std::clamp(0.8 * spread[i] + 0.2 * std::sqrt(wide), 1e-3, 2.0);
    }
  }
}

}  // namespace

std::unique_ptr<Subject> MakeSubject(const DeviceModel& m, const GameRules& rules,
                                     std::optional<LawKind> law, double energy) {
  if (law) return std::make_unique<CouplingSubject>(m, rules, *law);
  return std::make_unique<GuardedSpring>(m, rules, energy);
}

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
