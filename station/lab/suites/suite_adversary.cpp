#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <optional>

#include "common/haptics/uniform_material.h"
#include "station/lab/suites/adversary.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

using haptics::LawKind;

// The theorem's balance above its floor -V_0, and what was taken out of the law alone.
struct Ledger {
  double balance = 0, lowest = 0, handed = 0, taken = 0;
  void Add(double work, double paid) {
    balance += work + paid;
    handed += work;
    taken = std::max(taken, -handed);
  }
};

struct PlainGame {
  PlainGame(const DeviceModel& m, LawKind law)
      : model(m), coupling(Params(m, law)), b_over_t(m.damping_n_s_per_m / m.tick_s()) {
    // The least friction the theorem allows; a device's surplus only helps.
    friction = std::min(m.friction_n, m.kc_n_per_m * m.resolution_m / 2);
    // Also Kc = 2 b/T at most, hence b/T at least Kc/2.
    b_over_t = std::min(b_over_t, m.kc_n_per_m / 2);
  }
  static haptics::CouplingParams Params(const DeviceModel& m, LawKind law) {
    haptics::CouplingParams p;
    p.law.kind = law;
    p.law.kc_n_per_m = m.kc_n_per_m;
    p.law.resolution_m = dvec3(m.resolution_m);
    p.law.tick_s = m.tick_s();
    p.peak_force_n = m.peak_force_n;
    return p;
  }
  void Start(const dvec3& x0) {
    x = x0;
    force = dvec3(0);
    coupling.Reset(CellMiddle(x, model.resolution_m));
    material.contact.clearance_m = 1;
    Rebase();
  }
  // The floor starts here: V_0 is the spring's energy now, E_0 the tank's.
  void Rebase() {
    dvec3 stretch = x - coupling.rest_m();
    floor = -0.5 * model.kc_n_per_m * Dot(stretch, stretch) - coupling.tank_j();
    ledger = Ledger{};
  }
  // Moves the tip while the last force is held, then one tick. Returns the balance above the floor.
  double Move(const dvec3& dx) {
    ledger.Add(
        Dot(force, dx),
        b_over_t * Dot(dx, dx) + friction * (std::fabs(dx.x) + std::fabs(dx.y) + std::fabs(dx.z)));
    x += dx;
    force = -coupling.Tick(CellMiddle(x, model.resolution_m), bound_ratio, material).force_sent_n;
    double above = ledger.balance - floor;
    ledger.lowest = std::min(ledger.lowest, above);
    return above;
  }

  const DeviceModel& model;
  haptics::Coupling coupling;
  haptics::UniformMaterial material;
  double b_over_t, friction = 0, floor = 0, bound_ratio = 1;
  dvec3 x{0}, force{0};
  Ledger ledger;
};

Attack NotPlayed(const char* kind, const DeviceModel& m, LawKind law, uint64_t seed,
                 int64_t length) {
  Attack a;
  a.law = haptics::FindLaw(law)->name;
  a.kind = kind;
  a.profile = m.name;
  a.seed = seed;
  a.length = length;
  a.proved = ProvedLaw(law);
  return a;
}

void RandomB(Random& r, haptics::Contact* contact) {
  Sym3 b;
  int rank = r.Below(4);
  for (int i = 0; i < rank; ++i) b += Sym3::Outer(r.Direction(), r.LogBetween(1, 1e6));
  contact->damping_n_s_per_m = b;
  contact->engaged = rank > 0;
  // An occasional wall: the bur has stopped.
  contact->wall_normal = r.Below(16) == 0 ? r.Direction() : dvec3(0);
}

// A periodic motion and a material that follows its phase: 3 axes x 2 harmonics x (sine, cosine),
// length of the period, and B per eighth of it (logarithm, and whether it is a normal only).
struct Motion {
  static constexpr size_t kSize = 12 + 1 + 16;
  std::array<double, kSize> g{};
  double period() const { return 4 + 60 / (1 + std::exp(-g[12])); }
  dvec3 At(double phase, double delta) const {
    dvec3 x(0);
    for (int axis = 0; axis < 3; ++axis) {
      for (int h = 0; h < 2; ++h) {
        auto at = static_cast<size_t>(4 * axis + 2 * h);
        x[axis] += g[at] * std::sin(2 * M_PI * (h + 1) * phase) +
                   g[at + 1] * std::cos(2 * M_PI * (h + 1) * phase);
      }
    }
    return x * delta;
  }
};

double PlayMotion(PlainGame& game, const Motion& motion, Attack* attack) {
  double delta = game.model.resolution_m;
  game.Start(motion.At(0, delta));
  // Six periods of the longest motion and a hundred of the shortest: a pump adds up.
  constexpr int kTicks = 400;
  for (int k = 1; k <= kTicks; ++k) {
    double phase = k / motion.period();
    phase -= std::floor(phase);
    auto part = static_cast<size_t>(phase * 8);
    double b = std::exp(std::clamp(motion.g[13 + part], -3.0, 16.0));
    bool normal_only = motion.g[21 + part] > 0.5;
    game.material.contact.damping_n_s_per_m =
        normal_only
            ? Sym3::Outer(
                  glm::normalize(dvec3(1, 0.5 + motion.g[13 + part] * 0.1, motion.g[21 + part])), b)
            : Sym3::Isotropic(b);
    game.material.contact.engaged = true;
    double above = game.Move(motion.At(phase, delta) - game.x);
    if (above < -kRounding_j) ++attack->violations;
    ++attack->ticks;
  }
  attack->worst_j = std::min(attack->worst_j, game.ledger.lowest);
  attack->extracted_j = std::max(attack->extracted_j, game.ledger.taken);
  return game.ledger.balance - game.floor;
}

}  // namespace

Attack PlayRandom(const DeviceModel& m, LawKind law, uint64_t seed, int64_t ticks) {
  Attack a =
      NotPlayed("random walk, random B, P, walls and bounds every tick", m, law, seed, ticks);
  Random r(seed);
  PlainGame game(m, law);
  int64_t until = 0;
  dvec3 v(0);
  double pace = m.resolution_m, memory = 0.9;
  for (int64_t tick = 0; tick < ticks; ++tick) {
    if (tick == until) {
      until = tick + 2000;
      pace = m.resolution_m * r.LogBetween(1e-3, 30);
      memory = r.Uniform();
      game.bound_ratio = r.Below(4) == 0 ? r.Uniform() : 1;
      game.Start(dvec3(r.Signed(), r.Signed(), r.Signed()) * 1e-4);
      if (r.Below(2)) {
        // Loaded: the bur in something hard, the tip pushed on; the floor starts there.
        game.material.contact.damping_n_s_per_m = Sym3::Isotropic(1e8);
        game.material.contact.engaged = true;
        for (int i = 0; i < 20; ++i) game.Move(r.Direction() * (m.resolution_m * r.Between(0, 20)));
        game.Rebase();
      }
    }
    RandomB(r, &game.material.contact);
    // Half of the time the adversary leans to where the force helps him.
    v = v * memory + r.Direction() * (pace * r.Uniform());
    if (r.Below(2)) v -= game.force * (pace * r.Uniform() / (glm::length(game.force) + 1e-9));
    double above = game.Move(v);
    if (above < -kRounding_j) ++a.violations;
    a.worst_j = std::min(a.worst_j, above);
    a.extracted_j = std::max(a.extracted_j, game.ledger.taken + game.floor);
    ++a.ticks;
  }
  return a;
}

Attack PlaySearch(const DeviceModel& m, LawKind law, uint64_t seed, int rounds) {
  Attack a = NotPlayed("evolved periodic motion and material", m, law, seed, rounds);
  Random r(seed);
  PlainGame game(m, law);
  Motion best;
  for (double& g : best.g) g = r.Normal();
  for (size_t i = 13; i < 21; ++i) best.g[i] = r.Between(0, 12);
  double lowest = PlayMotion(game, best, &a), size = 1;
  for (int round = 1; round < rounds; ++round) {
    Motion next = best;
    // A third of the genes at a time: a change of all of them at once is rarely better.
    for (double& g : next.g) g += size * r.Normal() * (r.Below(3) == 0);
    double score = PlayMotion(game, next, &a);
    // One-fifth rule.
    size = std::clamp(size * (score < lowest ? 1.5 : 0.92), 0.01, 5.0);
    if (score < lowest) {
      lowest = score;
      best = next;
    }
  }
  return a;
}

void RunAdversarySuite(SuiteContext& c) {
  int64_t ticks = c.options.adversary_ticks > 0 ? c.options.adversary_ticks
                  : c.options.quick             ? 2'000'000
                                                : 1'000'000'000;
  struct Job {
    const DeviceModel* model;
    LawKind law;
    uint64_t seed;
    int64_t ticks;
    bool search;
    // For a game of adversary.h; law is not used.
    std::optional<GameRules> rules;
    GameKind kind = GameKind::kWalk;
    std::optional<LawKind> against;
  };
  std::vector<Job> jobs;
  // Jobs of equal length, so that threads end together; a game is repeated by its own seed alone.
  constexpr int kParts = 16;
  auto models = static_cast<int64_t>(c.findings.models.size());
  uint64_t seed = c.options.seed;
  for (const DeviceModel& m : c.findings.models) {
    for (const auto& law : haptics::ForceLaws()) {
      // Most of the ticks go to proved cases.
      int64_t share = ProvedLaw(law.kind) ? ticks / 5 / models : ticks / 60 / models;
      for (int part = 0; part < kParts; ++part) {
        jobs.push_back({&m,
                        law.kind,
                        seed++,
                        std::max<int64_t>(share / kParts * 3 / 4, 2000),
                        false,
                        {},
                        {},
                        {}});
        if (part % 4 == 0) {
          jobs.push_back(
              {&m, law.kind, seed++, std::max<int64_t>(share / kParts, 4000), true, {}, {}, {}});
        }
      }
    }
  }
  // Every rule against the guard alone and against the laws that use it.
  std::vector<std::optional<LawKind>> subjects = {std::nullopt};
  for (const auto& law : haptics::ForceLaws())
    if (ProvedLaw(law.kind)) subjects.push_back(law.kind);
  std::vector<GameRules> rules = AllRules();
  int64_t games = models * static_cast<int64_t>(rules.size() * subjects.size()) * kGameKinds;
  for (const DeviceModel& m : c.findings.models) {
    for (const GameRules& rule : rules) {
      for (const auto& subject : subjects) {
        for (int kind = 0; kind < kGameKinds; ++kind) {
          jobs.push_back({&m, LawKind::kMaxwell, seed++, std::max<int64_t>(ticks / 2 / games, 1000),
                          false, rule, static_cast<GameKind>(kind), subject});
        }
      }
    }
  }
  std::vector<Attack> played(jobs.size());
  std::atomic<size_t> done{0};
  ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
    const Job& j = jobs[i];
    if (j.rules)
      played[i] =
          PlayGame(*j.model, *j.rules, j.against, j.kind, j.seed,
                   // A search counts in rounds of about 360 ticks.
                   j.kind < GameKind::kBred ? j.ticks : std::max<int64_t>(j.ticks / 200, 12));
    else
      played[i] = j.search ? PlaySearch(*j.model, j.law, j.seed, static_cast<int>(j.ticks / 400))
                           : PlayRandom(*j.model, j.law, j.seed, j.ticks);
    c.progress("adversary", ++done, jobs.size());
  });
  // One line per law and kind: the worst, with the seed that repeats it.
  Table t;
  t.title =
      "Adversary: 3-D motion, B, walls and bounds that change every tick, from loaded and unloaded "
      "starts; delay, noise, turned lattices, gaps and late ticks";
  t.head = {"law",
            "game",
            "ticks",
            "lowest balance above its floor J",
            "most taken out of the law alone J",
            "violations",
            "worst game",
            "claim"};
  t.note =
      "Balance: sum of R.dx + (b/T) dx.dx + c sum|dx_i| with b and c at the least the theorem "
      "allows (each delay and cell its own); the floor is -(V_0 + E_0), and Kc/2 (radius of the "
      "cell)^2 "
      "lower for every gap. Taken out alone: minus "
      "the lowest sum of R.dx, more than was stored at the start. Where the law is proved the "
      "violations must be 0.";
  std::vector<Attack> merged;
  for (const Attack& a : played) {
    auto same = std::find_if(merged.begin(), merged.end(),
                             [&](const Attack& b) { return b.law == a.law && b.kind == a.kind; });
    if (same == merged.end()) {
      merged.push_back(a);
      continue;
    }
    if (a.worst_j < same->worst_j) {
      same->made = a.made;
      same->profile = a.profile;
      same->seed = a.seed;
      same->length = a.length;
      same->worst_j = a.worst_j;
    }
    same->extracted_j = std::max(same->extracted_j, a.extracted_j);
    same->ticks += a.ticks;
    same->violations += a.violations;
  }
  for (const Attack& a : merged) {
    char worst[40], taken[40];
    std::snprintf(worst, sizeof worst, "%.3g", a.worst_j);
    std::snprintf(taken, sizeof taken, "%.3g", a.extracted_j);
    t.rows.push_back(
        {a.law, a.kind, std::to_string(a.ticks), worst, taken, std::to_string(a.violations),
         (a.made.empty() ? "" : a.made + " ") + a.profile + " seed " + std::to_string(a.seed) +
             " length " + std::to_string(a.length),
         a.proved ? (a.violations == 0 ? "proved, held" : "PROVED, VIOLATED") : "not proved"});
    c.findings.attacks.push_back(a);
  }
  c.findings.tables.push_back(std::move(t));
}

}  // namespace enamel::station::lab
