#include <algorithm>
#include <atomic>
#include <cstdio>

#include "station/lab/suites/adversary.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

using haptics::LawKind;

struct Job {
  const DeviceModel* model;
  GameRules rules;
  Target target;
  GameKind kind;
  uint64_t seed;
  int64_t ticks;
};

// A search counts in rounds of about 360 ticks, and needs a dozen to be one.
int64_t LengthOf(const Job& job) {
  return job.kind < GameKind::kBred ? job.ticks : std::max<int64_t>(job.ticks / 360, 12);
}

// Of a thousand ticks, `share` go to each game of the kind.
struct Field {
  std::vector<GameRules> rules;
  std::vector<Target> targets;
  std::vector<GameKind> kinds;
  double share;
};

std::vector<Field> FieldsOf() {
  const std::vector<GameKind> all = {GameKind::kWalk, GameKind::kDither, GameKind::kPress,
                                     GameKind::kBred, GameKind::kPopulation};
  std::vector<Target> proved = {{}}, cores, others;
  for (const auto& law : haptics::ForceLaws()) {
    const bool has_proof = ProvedLaw(law.kind);
    (has_proof ? proved : others).push_back({law.kind});
    if (has_proof) cores.push_back({law.kind, true});
  }
  proved.push_back({haptics::kDefaultLaw, false, true});
  cores.push_back({haptics::kDefaultLaw, true, true});
  std::vector<GameRules> ordinary, excluded = ExcludedRules();
  // Whether a bound holds back the core's force is not the adversary's to say.
  for (const GameRules& rules : AllRules())
    if (!rules.bounds) ordinary.push_back(rules);
  return {{AllRules(), proved, all, 0.93},
          // A tick of the whole core costs ten of the coupling's.
          {ordinary, cores, {GameKind::kWalk, GameKind::kPress, GameKind::kBred}, 0.03},
          {excluded, proved, all, 0.02},
          {{{}}, others, {GameKind::kWalk, GameKind::kBred}, 0.02}};
}

std::vector<Job> JobsFor(const SuiteContext& c, int64_t ticks) {
  std::vector<Job> jobs;
  uint64_t seed = c.options.seed;
  for (const Field& field : FieldsOf()) {
    const size_t games =
        c.findings.models.size() * field.rules.size() * field.targets.size() * field.kinds.size();
    const auto each =
        static_cast<int64_t>(field.share * static_cast<double>(ticks) / static_cast<double>(games));
    for (const DeviceModel& m : c.findings.models) {
      for (const GameRules& rules : field.rules) {
        for (const Target& target : field.targets) {
          for (GameKind kind : field.kinds)
            jobs.push_back({&m, rules, target, kind, seed++, std::max<int64_t>(each, 500)});
        }
      }
    }
  }
  return jobs;
}

}  // namespace

void RunAdversarySuite(SuiteContext& c) {
  const int64_t ticks = c.options.adversary_ticks > 0 ? c.options.adversary_ticks
                        : c.options.quick             ? 2'000'000
                                                      : 1'000'000'000;
  const std::vector<Job> jobs = JobsFor(c, ticks);
  std::vector<Attack> played(jobs.size());
  std::atomic<size_t> done{0};
  ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
    const Job& j = jobs[i];
    played[i] = PlayGame(*j.model, j.rules, j.target, j.kind, j.seed, LengthOf(j));
    c.progress("adversary", ++done, jobs.size());
  });
  // One line per law and kind: the worst, with the seed that repeats it.
  Table t;
  t.title =
      "Adversary in the core's order: 3-D motion, B, walls and bounds that change every tick, from "
      "loaded and unloaded starts; delay, noise, turned lattices, gaps, late ticks, loop rates";
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
      "lower each time the force comes on again after a gap. Taken out alone: minus "
      "the lowest sum of R.dx, more than was stored at the start. Where the law is proved the "
      "violations must be 0; untold delay and noise and Kc above the clause must be found.";
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
