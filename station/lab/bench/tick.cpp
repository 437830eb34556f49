#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "common/cutting/voxel_limit.h"
#include "common/program/example.h"
#include "common/program/log.h"
#include "station/lab/bench/bench.h"
#include "station/lab/bench/peers.h"
#include "station/lab/cutting/tick_cost.h"

namespace enamel::station::lab::bench {
namespace {

struct TickOptions {
  std::string json;
  bool quick = false, peers = false;
  int replays = 9;
  size_t ticks = 1000;
};

// Goals for the headline case: cylinder r 0.6 x 4 mm, half embedded, 5 mm/s.
struct Goal {
  int32_t voxel_nm;
  double mean_us, p99_us;
};
constexpr Goal kGoals[] = {{50'000, 12, 25}, {25'000, 50, 100}};
// Halving the voxel gives four times as many on the bur's surface; its volume would give eight.
constexpr double kGrowthGoal = 4;

bool IsHeadline(const CutCase& c) {
  return c.bur == CutCase().bur && c.speed_m_s == CutCase().speed_m_s;
}

std::vector<CutCase> Cases(bool quick) {
  constexpr int32_t kVoxels_nm[] = {100'000, 50'000, 25'000};
  std::vector<CutCase> out;
  auto add = [&](CutCase c) {
    for (int32_t voxel : kVoxels_nm) {
      c.voxel_nm = voxel;
      out.push_back(c);
    }
  };
  add({});
  if (quick) return out;
  for (double speed : {1e-3, 20e-3}) {
    CutCase c;
    c.speed_m_s = speed;
    add(c);
  }
  for (Sunk sunk : {Sunk::kWhole, Sunk::kLying}) {
    CutCase c;
    c.sunk = sunk;
    add(c);
  }
  std::vector<CutCase> burs = BurCases();
  // The first bur is the headline's, which was added with every depth and speed.
  for (size_t i = 1; i < burs.size(); ++i) {
    for (double speed : {1e-3, 5e-3, 20e-3}) {
      CutCase c = burs[i];
      c.speed_m_s = speed;
      add(c);
    }
  }
  return out;
}

void PrintRow(const CutCase& c, const TickCost& t, double growth) {
  std::printf("%-36s %-6s %6.3f %5g %6zu %9.2f %8.2f %9.2f %8.2f %10.4f", BurText(c.bur).c_str(),
              SunkName(c.sunk), c.voxel_nm * 1e-6, c.speed_m_s * 1e3, t.ticks, t.mean_us, t.p99_us,
              t.raw_mean_us, t.raw_p99_us, t.removed_mm3);
  if (growth > 0) std::printf("  x%.1f", growth);
  std::printf("%s\n", t.engaged_share < 1 ? "  NOT ALWAYS ENGAGED" : "");
}

void PrintGoals(const CutCase& c, const TickCost& t) {
  if (!IsHeadline(c)) return;
  for (const Goal& g : kGoals) {
    if (g.voxel_nm != c.voxel_nm) continue;
    std::printf("  %s, %s embedded, %g mm/s, %g mm: mean %s us, p99 %s us\n",
                BurText(c.bur).c_str(), SunkName(c.sunk), c.speed_m_s * 1e3, c.voxel_nm * 1e-6,
                AgainstGoal(t.mean_us, g.mean_us).c_str(), AgainstGoal(t.p99_us, g.p99_us).c_str());
  }
}

// The others are far slower: more ticks would take minutes and show the same.
constexpr size_t kPeerTicks = 200;
constexpr int kPeerReplays = 3;
constexpr char kPeerMethod[] =
    "the headline's block, bur, voxel and poses (where the core cut, tick by tick) given to others "
    "in "
    "this run, one thread; per tick the least of 3 replays over 200 ticks. 'this tick' is all of a "
    "tick, which renews a cut only when it would leave a mark; the others cut only, and in every "
    "tick. OpenVDB: a narrow band of 3 voxels with the block's own samples; 'accessor' puts the "
    "bur's "
    "distance into those voxels of the bur's box that are not air, 'csgDifference' makes the bur's "
    "level set again and subtracts it, as in its manual. It keeps no tissues";

// The same cut by other programs, as a multiple of this tick's cost.
void ComparePeers(Rows& rows) {
  if (!HasOpenVdb()) {
    std::printf(
        "\nPeers: built without OpenVDB. Install it (Debian: libopenvdb-dev), configure and build "
        "again.\n");
    return;
  }
  std::printf("\nPeers: %s.\n\n%6s  %-22s %10s %10s %10s %12s %12s\n", kPeerMethod, "voxel", "",
              "mean us", "p99 us", "mm3", "over tick", "over cutter");
  for (CutCase c : Cases(true)) {
    CutPath path = MakeCutPath(c, kPeerTicks);
    const TickCost tick = TimeTicks(path, kPeerReplays);
    const std::vector<cutting::Pose> poses = PosesOf(path);
    const PeerCost cutter = TimeCutter(path, poses, kPeerReplays);
    std::vector<PeerCost> all{{"this tick", tick.mean_us, tick.p99_us, cutter.removed_mm3}, cutter};
    for (PeerCost& peer : TimeOpenVdb(path, poses, kPeerReplays)) all.push_back(std::move(peer));
    for (const PeerCost& one : all) {
      const double over_tick = one.mean_us / tick.mean_us,
                   over_cutter = one.mean_us / cutter.mean_us;
      std::printf("%6.3f  %-22s %10.2f %10.2f %10.4f %12.3g %12.3g\n", c.voxel_mm(),
                  one.what.c_str(), one.mean_us, one.p99_us, one.removed_mm3, over_tick,
                  over_cutter);
      rows.Add({{"peer", one.what},
                {"bur", BurText(c.bur)},
                {"voxel_mm", c.voxel_mm()},
                {"speed_mm_s", c.speed_m_s * 1e3},
                {"ticks", tick.ticks},
                {"mean_us", one.mean_us},
                {"p99_us", one.p99_us},
                {"removed_mm3", one.removed_mm3},
                {"over_this_tick", over_tick},
                {"over_this_cutter", over_cutter}});
    }
  }
}

int RunTick(const TickOptions& options) {
  if (!CanWrite(options.json)) return 1;
  std::string method = "per tick the least of " + std::to_string(options.replays) +
                       " identical replays of one path on fresh cores, then mean and 99th "
                       "percentile over ticks; raw: over all "
                       "ticks of all replays. A tick is core::Core::Step: cut, engagement, force, "
                       "hash. The bur moves sideways "
                       "through a block and is engaged in every tick that counts; half: upright "
                       "with half its height in the "
                       "block, whole: all of it, lying: axis in the surface";
  std::printf("Method: %s.\n\n", method.c_str());
  std::printf("%-36s %-6s %6s %5s %6s %9s %8s %9s %8s %10s  growth per halving\n", "bur", "sunk",
              "voxel", "mm/s", "ticks", "mean us", "p99 us", "raw mean", "raw p99", "mm3");
  Rows rows("tick", method);
  std::vector<std::pair<CutCase, TickCost>> headline;
  // Cases run from coarse to fine, so that each finds the one before.
  std::map<std::tuple<std::string, Sunk, double>, double> coarser;  // mean of the voxel before
  double worst_growth = 0;
  std::vector<CutCase> cases = Cases(options.quick);
  for (size_t i = 0; i < cases.size(); ++i) {
    const CutCase& c = cases[i];
    TickCost cost;
    {
      Progress progress;
      std::string what = BurText(c.bur) + ", voxel " + std::to_string(c.voxel_nm / 1000) + " um";
      cost = TimeTicks(MakeCutPath(c, options.ticks), options.replays, [&](int done, int all) {
        progress.Show(what, (static_cast<double>(i) + static_cast<double>(done) / all) /
                                static_cast<double>(cases.size()));
      });
    }
    // Also checks determinism: otherwise the server could not replay it.
    if (!cost.replays_agree) {
      program::SayError(
          "replays of one path ended in different states; the core is not "
          "deterministic here");
      return 1;
    }
    double& before = coarser[{BurText(c.bur), c.sunk, c.speed_m_s}];
    double growth = before > 0 ? cost.mean_us / before : 0;
    before = cost.mean_us;
    if (IsHeadline(c)) {
      headline.push_back({c, cost});
      worst_growth = std::max(worst_growth, growth);
    }
    PrintRow(c, cost, growth);
    boost::json::object row{{"bur", BurText(c.bur)},
                            {"sunk", SunkName(c.sunk)},
                            {"voxel_mm", c.voxel_nm * 1e-6},
                            {"speed_mm_s", c.speed_m_s * 1e3},
                            {"rate_hz", c.rate_hz},
                            {"ticks", cost.ticks},
                            {"replays", cost.replays},
                            {"mean_us", cost.mean_us},
                            {"p99_us", cost.p99_us},
                            {"raw_mean_us", cost.raw_mean_us},
                            {"raw_p99_us", cost.raw_p99_us},
                            {"removed_mm3", cost.removed_mm3},
                            {"engaged_share", cost.engaged_share}};
    if (growth > 0) row["growth_per_halving"] = growth;
    rows.Add(std::move(row));
  }
  std::printf("\nGoals:\n");
  for (const auto& [c, cost] : headline) PrintGoals(c, cost);
  std::printf("  growth per halving of the voxel, worst of these: %s\n",
              AgainstGoal(worst_growth, kGrowthGoal).c_str());
  if (options.peers) ComparePeers(rows);
  return rows.Write(options.json);
}

}  // namespace

void RegisterTick(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<TickOptions>();
  CLI::App* tick = app.add_subcommand("tick", "Microseconds a tick: burs x voxel sizes x speeds");
  tick->add_flag("--quick", options->quick,
                 "The headline case only (cylinder r 0.6 x 4 mm at 5 mm/s)");
  tick->add_flag(
      "--peers", options->peers,
      "Then the headline case by OpenVDB's level set too, in the same run, and the ratio");
  tick->add_option("--replays", options->replays, "Identical replays of each path")
      ->check(CLI::Range(5, 1000))
      ->capture_default_str();
  tick->add_option("--ticks", options->ticks, "Ticks measured on each path, at most")
      ->check(CLI::Range(100, 100'000))
      ->capture_default_str();
  tick->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*tick, {"--quick --json tick.json"});
  tick->callback([options, exit_code] { *exit_code = RunTick(*options); });
}

}  // namespace enamel::station::lab::bench
