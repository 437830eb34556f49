#include <algorithm>
#include <array>
#include <cmath>

#include "station/lab/suites/attacks.h"

namespace enamel::station::lab {
namespace {

using haptics::Contact;

// One contact in four is tissue that is cut by load, with a drag of up to five peaks that the spindle pays for.
void RandomContact(Random& r, Turn* turn) {
  Contact* contact = &turn->contact;
  Sym3 b;
  // Directions that resist: none in air, three in solid tissue.
  int rank = r.Below(4);
  for (int i = 0; i < rank; ++i) b += Sym3::Outer(r.Direction(), r.LogBetween(1, 1e6));
  contact->damping_n_s_per_m = b;
  contact->engaged = rank > 0;
  contact->wall_normal = r.Below(16) == 0 ? r.Direction() : dvec3(0);
  contact->clearance_m = rank == 0 ? 1 : 0;
  contact->by_load = rank > 0 && r.Below(4) == 0;
  turn->load = {r.Below(3) == 0 ? 0 : r.LogBetween(1e-3, 10), r.LogBetween(1, 1e4),
                r.Below(2) == 0 ? 0 : r.LogBetween(1, 1e5)};
  turn->drag_n = r.Below(2) == 0 ? dvec3(0) : r.Direction() * r.LogBetween(0.01, 30);
}

}  // namespace

dmat3 RandomFrame(Random& r) {
  dvec3 a = r.Direction(), b = r.Direction();
  b = glm::normalize(b - a * Dot(a, b));
  return {a, b, glm::cross(a, b)};
}

void PlayCounted(Game& game, const Turn& turn, Attack* attack) {
  const double above = game.Play(turn);
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
      if (rules.delay_ticks == 0 && rules.late == GameRules::Late::kNone && r.Below(2) &&
          game.can_rebase()) {
        turn.contact.damping_n_s_per_m = Sym3::Isotropic(1e8);
        turn.contact.engaged = true;
        for (int i = 0; i < 20; ++i) {
          turn.way_m = r.Direction() * (game.delta_m() * r.Between(0, 20));
          game.Play(turn);
        }
        game.Rebase();
      }
    }
    if (tick % steady == 0) RandomContact(r, &turn);
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
      turn.noise[i] = r.Below(2 * rules.counts_off() + 1) - rules.counts_off();
    turn.late = r.Below(6) == 0;
    turn.late_is_lost_tick = r.Below(2);
    turn.gap_ticks = r.Below(40) == 0 ? 1 + r.Below(2 * rules.delay_ticks + 3) : 0;
    turn.gap_way_m = r.Direction() * (pace * r.LogBetween(0.1, 100));
    PlayCounted(game, turn, attack);
  }
}

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
      if (rules.counts_off() > 0 && !known) {
        for (int i = 0; i < 3; ++i)
          turn.noise[i] = r.Below(2 * rules.counts_off() + 1) - rules.counts_off();
      }
      if (rules.bounds) turn.bound_ratio = (air >> (16 + k % period)) & 1 ? 1 : 0;
      turn.late = turn.late_is_lost_tick = (air >> (32 + k % period)) & 1;
      turn.gap_ticks = k % period == 0 && (air >> 48 & 3) == 0 ? 1 + rules.delay_ticks : 0;
      turn.gap_way_m = way * reach;
      PlayCounted(game, turn, attack);
    }
  }
}

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
        turn.noise[i] = r.Below(2 * rules.counts_off() + 1) - rules.counts_off();
      PlayCounted(game, turn, attack);
      ++played;
    };
    for (int cycle = 0; cycle < 4; ++cycle) {
      for (int k = 0; k < press; ++k) Play(in, bound_in ? 1 : 0, false);
      for (int k = 0; k < jerks; ++k) {
        turn.gap_ticks = 1 + rules.delay_ticks;
        turn.gap_way_m = in * back;
        Play(-in * jerk, 1, false);
        turn.gap_ticks = 0;
      }
      for (int k = 0; k < press; ++k) Play(-in, 1, soft_out);
    }
  }
}

}  // namespace enamel::station::lab
