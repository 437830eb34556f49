#include <algorithm>
#include <cmath>

#include "station/lab/suites/attacks.h"

namespace enamel::station::lab {
namespace {

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
    // Genes that a bare spring alone reads.
    t.contact.by_load = t.contact.engaged && q[8] < -0.5;
    if (t.contact.by_load) {
      t.load = {std::exp(std::clamp(4 * q[9], -8.0, 3.0)), std::sqrt(b), 0};
      t.drag_n = dvec3(q[5], q[6], q[7]) * 3.0;
    }
    if (q[8] > 0) t.push_m = dvec3(q[5], q[6], q[7]) * scale;
    if (rules.bounds) t.bound_ratio = q[9] > 1 ? 0 : q[9] > 0 ? 1 : std::exp(3 * q[9]);
    for (int i = 0; i < 3; ++i) {
      double counts = std::clamp(q[10 + i], -1.0, 1.0) * (rules.counts_off() + 0.49);
      t.noise[i] = static_cast<int>(std::lround(counts));
    }
    t.late = q[13] > 1;
    t.late_is_lost_tick = q[14] > 0;
    // One time in fifteen; most gaps are longer than a bus's delay.
    if (rules.gaps && q[15] > 1.5)
      t.gap_ticks = 1 + std::min(static_cast<int>(8 * (q[15] - 1.5)), 8);
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
    PlayCounted(game, s.At(k, game, rules), attack);
  }
  return (settled - game.owed()) / (game.paid_j() - paid + 1e-15);
}

}  // namespace

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

}  // namespace enamel::station::lab
