#include "station/lab/suites/hand_cases.h"

#include <algorithm>
#include <cmath>

#include "station/lab/laws/approach.h"
#include "station/lab/laws/lift.h"
#include "station/lab/laws/withdrawal.h"

namespace enamel::station::lab {
namespace {

using fidelity::FeltFigures;
using fidelity::FeltTrial;
using fidelity::HandOn;
using haptics::LawKind;

constexpr double kEnamel = 6500, kCut_m_per_s = 0.43e-3;  // the paper's
// Below it the grip hardly moves the device, and nobody feels it.
constexpr double kMinFelt_n = 0.02;
// Grips of 0.3 to 5 N/mm, and two that hardly give.
constexpr double kGrips_n_per_m[] = {300, 1000, 2000, 5000, 20'000};

std::vector<HandOn> AllGrips() {
  std::vector<HandOn> all;
  for (double k : kGrips_n_per_m) all.push_back({.stiffness_n_per_m = k});
  all.push_back({});
  return all;
}

// Joints turned any way; the same on every machine.
Lattice Turned(uint64_t seed, double cell_m, bool rounds, int noise) {
  Random r(seed);
  const dvec3 x = r.Direction(), y = glm::normalize(glm::cross(r.Direction(), x));
  Lattice l;
  l.joints = glm::transpose(glm::dmat3(x, y, glm::cross(x, y)));
  l.driver_cell_m = rounds ? cell_m : 0;
  l.noise_counts = noise;
  return l;
}

std::string NameOf(const Lattice& l) {
  std::string name = l.joints == glm::dmat3(1) ? "cartesian" : "turned";
  if (l.driver_cell_m > 0) name += "-rounded";
  if (l.noise_counts > 0) name += "-count";
  return name;
}

void Hold(const HandOn& hand, HandRow* row) {
  if (!hand.stiffness_n_per_m) return;
  row->hand_n_per_mm = *hand.stiffness_n_per_m * 1e-3;
  row->hand_kg = hand.mass_kg;
}

// The default law and plain Maxwell in the same trial.
void AddTrial(const DeviceModel& m, HandRow row, const FeltTrial& trial,
              const std::vector<dvec3>& way, HandCases* out) {
  Hold(trial.hand, &row);
  out->push_back({std::move(row), [m, trial, way](HandRow& r) {
                    FeltTrial plain = trial;
                    plain.law = LawKind::kMaxwell;
                    plain.tool = false;
                    const FeltFigures a = Feel(FeltDeviceOf(m), trial, way);
                    const FeltFigures b = Feel(FeltDeviceOf(m), plain, way);
                    if (a.ideal_rms_n > kMinFelt_n) {
                      r.felt_error = a.command_error();
                      r.maxwell_error = b.command_error();
                      r.ideal_rms_n = a.ideal_rms_n;
                    }
                    SetFelt(a, &r);
                    r.ripple_n = a.ripple_n;
                    r.maxwell_ripple_n = b.ripple_n;
                    r.energy_min_j = a.energy_min_j;
                  }});
}

}  // namespace

void SetFelt(const FeltFigures& f, HandRow* row) {
  row->felt_error_rms_n = f.felt_error_rms_n;
  row->felt_error_p95_n = f.felt_error_p95_n;
  row->tool_rms_n = f.tool_rms_n;
}

HandRow RowFor(const DeviceModel& m, double b, const std::string& motion, const Lattice& lattice,
               int delay_ticks) {
  HandRow row;
  row.device = m.name;
  row.motion = motion;
  row.lattice = NameOf(lattice);
  row.b_n_s_per_mm = b * 1e-3;
  row.rate_hz = m.spring_hz();
  row.on_board = m.board.ticks > 0;
  row.kc_n_per_mm = m.kc_n_per_m * 1e-3;
  row.delay_ticks = delay_ticks;
  const double most = ClauseKc(m, fidelity::CellOf(lattice, m.resolution_m), delay_ticks);
  // A profile's Kc may be the very limit, rounded to whole mN/mm and back.
  row.proved = m.mode_hz == 0 && m.kc_n_per_m <= most * (1 + 1e-9);
  return row;
}

void AddFeltCases(const DeviceModel& m, const std::vector<HandMotion>& motions,
                  const std::vector<double>& tissues, HandCases* out) {
  for (double b : tissues) {
    for (const HandMotion& motion : motions) {
      for (const HandOn& hand : AllGrips()) {
        FeltTrial trial;
        trial.b_n_s_per_m = Sym3::Isotropic(b);
        trial.hand = hand;
        AddTrial(m, RowFor(m, b, motion.name, {}, 0), trial, motion.way_m, out);
      }
    }
  }
}

void AddReadingCases(const DeviceModel& model, const std::vector<HandMotion>& motions,
                     HandCases* out) {
  struct Reading {
    Lattice lattice;
    int delay_ticks = 0;
  };
  Lattice count;
  count.noise_counts = 1;
  const double cell = model.resolution_m;
  const Reading readings[] = {{Turned(1, cell, false, 0)},
                              {Turned(1, cell, true, 0)},
                              {Turned(1, cell, true, 1)},
                              {count},
                              {{}, 1}};
  for (const Reading& reading : readings) {
    const double clause =
        ClauseKc(model, fidelity::CellOf(reading.lattice, cell), reading.delay_ticks);
    std::vector<double> stiffnesses = {model.kc_n_per_m};
    if (clause < model.kc_n_per_m) stiffnesses.push_back(clause);
    for (double kc : stiffnesses) {
      DeviceModel m = model;
      m.kc_n_per_m = kc;
      for (const HandMotion& motion : motions) {
        for (const HandOn& hand : {HandOn{.stiffness_n_per_m = 1000}, HandOn{}}) {
          FeltTrial trial;
          trial.hand = hand;
          trial.lattice = reading.lattice;
          trial.delay_ticks = reading.delay_ticks;
          AddTrial(m, RowFor(m, kEnamel, motion.name, reading.lattice, reading.delay_ticks), trial,
                   motion.way_m, out);
        }
      }
    }
  }
}

void AddSteadyCases(const DeviceModel& m, HandCases* out) {
  constexpr int kLattices = 24;
  constexpr double kJudged_s = 2;
  Random directions(50);
  for (int i = 0; i < kLattices; ++i) {
    // A third of them along an axis, which is where rounding aligns with the cells.
    const dvec3 along = i % 3 == 0 ? dvec3(1, 0, 0) : directions.Direction();
    for (int noise : {0, 1}) {
      FeltTrial trial;
      trial.lattice = Turned(static_cast<uint64_t>(i) + 1, m.resolution_m, true, noise);
      // Until the plain spring has settled to a hundredth.
      trial.from_s = 2 + 4.6 * kEnamel / m.kc_n_per_m;
      const HandMotion way = ReversalMotion(kCut_m_per_s, trial.from_s + kJudged_s, 0, along);
      out->push_back({RowFor(m, kEnamel, "steady", trial.lattice, 0), [m, trial, way](HandRow& r) {
                        const FeltFigures f = Feel(FeltDeviceOf(m), trial, way.way_m);
                        r.off_rms_n = f.error_rms_n;
                        r.least_share = f.least_n / (kEnamel * kCut_m_per_s);
                        r.felt_error = f.command_error();
                        SetFelt(f, &r);
                        r.ripple_n = f.ripple_n;
                        r.energy_min_j = f.energy_min_j;
                      }});
    }
  }
}

namespace {

// Of the coupling alone, and with what holds it.
void RunPush(const DeviceModel& m, const FeltTrial& trial, double settle_s, HandRow& r) {
  const std::vector<dvec3> still(static_cast<size_t>((settle_s + 2) / fidelity::kWayStep_s),
                                 dvec3(0));
  FeltTrial plain = trial;
  plain.law = LawKind::kMaxwell;
  const FeltFigures a = Feel(FeltDeviceOf(m), trial, still);
  const FeltFigures p = Feel(FeltDeviceOf(m), plain, still);
  r.swing_n = a.most_n - a.least_n;
  r.maxwell_swing_n = p.most_n - p.least_n;
  r.ripple_n = a.ripple_n;
  r.maxwell_ripple_n = p.ripple_n;
  r.energy_min_j = a.energy_min_j;
}

}  // namespace

// At the feeds that 1/30 of each hand's load, a third and all of it cut with: the hand pushes with the tissue's own force
// there. Half, once and twice the hardness of enamel (scene/material.h).
void AddLoadPushCases(const DeviceModel& m, HandCases* out) {
  Random directions(6);
  for (double mass : {0.02, 0.05, 0.1, 0.2, 0.35, 0.5}) {
    for (double damping : {0.3, 1.0, 3.0, 10.0}) {
      for (double hardness : {0.5, 1.0, 2.0}) {
        for (double push_n : {0.5, 1.0, 2.0, 4.0}) {
          FeltTrial trial;
          trial.ideal = trial.tool = false;
          trial.load = FeedForce{0.2 * hardness, 2.6 * hardness / std::sqrt(0.43e-3), 0};
          trial.hand = {.stiffness_n_per_m = 0, .mass_kg = mass, .damping_n_s_per_m = damping};
          const double push = std::min(push_n, 0.9 * m.peak_force_n);
          const bool oblique = push_n == 1.0 || push_n == 4.0;
          trial.hand.push_n = (oblique ? directions.Direction() : dvec3(1, 0, 0)) * push;
          trial.from_s = 4;
          HandRow row = RowFor(m, 6'047 * hardness, "push-by-load", {}, 0);
          Hold(trial.hand, &row);
          out->push_back({std::move(row), [m, trial](HandRow& r) { RunPush(m, trial, 4, r); }});
        }
      }
    }
  }
}

void AddPushCases(const DeviceModel& m, HandCases* out) {
  Random directions(5);
  for (double mass : {0.02, 0.05, 0.1, 0.2, 0.35, 0.5}) {
    for (double damping : {0.3, 1.0, 3.0, 10.0}) {
      for (double b : {6500.0, 1000.0, 300.0}) {
        for (double speed : {0.1e-3, 0.2e-3, 0.43e-3, 0.8e-3}) {
          FeltTrial trial;
          trial.ideal = trial.tool = false;
          trial.b_n_s_per_m = Sym3::Isotropic(b);
          trial.hand = {.stiffness_n_per_m = 0, .mass_kg = mass, .damping_n_s_per_m = damping};
          const bool oblique = speed == 0.2e-3 || speed == 0.8e-3;
          trial.hand.push_n = (oblique ? directions.Direction() : dvec3(1, 0, 0)) *
                              std::min(b * speed, 0.9 * m.peak_force_n);
          const double settle_s = 4 + 3 * b / m.kc_n_per_m;
          trial.from_s = settle_s;
          HandRow row = RowFor(m, b, "push", {}, 0);
          Hold(trial.hand, &row);
          out->push_back({std::move(row),
                          [m, trial, settle_s](HandRow& r) { RunPush(m, trial, settle_s, r); }});
        }
      }
    }
  }
}

void AddLiftCases(const DeviceModel& m, HandCases* out) {
  for (const Lift& lift : AllLifts(haptics::kDefaultLaw)) {
    HandRow row = RowFor(m, kEnamel, lift.upward ? "lift-up" : "lift-back", {}, 0);
    row.hand_n_per_mm = lift.hand_n_per_m * 1e-3;
    out->push_back({std::move(row), [m, lift](HandRow& r) {
                      const LiftFigures f = RunLift(m, lift);
                      r.pull_n = f.pull_n;
                      r.cycles = f.rises >= 2;
                    }});
  }
}

void AddApproachCases(const DeviceModel& m, HandCases* out) {
  for (double speed : {2e-3, 10e-3, 50e-3}) {
    const std::string name = "approach-" + std::to_string(std::lround(speed * 1e3)) + "mm_s";
    for (bool wall : {false, true}) {
      Approach a;
      a.speed_m_per_s = speed;
      a.goes_on = true;
      a.wall = wall;
      out->push_back({RowFor(m, kEnamel, name + (wall ? "-wall" : ""), {}, 0), [m, a](HandRow& r) {
                        Approach plain = a;
                        plain.law = LawKind::kMaxwell;
                        const ApproachFigures f = RunApproach(m, a);
                        r.way_m = f.way_m;
                        r.behind_m = f.behind_m;
                        r.maxwell_way_m = RunApproach(m, plain).way_m;
                      }});
    }
    for (double b : {6500.0, 1000.0, 300.0}) {
      Approach a;
      a.speed_m_per_s = speed;
      a.b_n_s_per_m = b;
      out->push_back({RowFor(m, b, "first-stroke-after-" + name.substr(9), {}, 0),
                      [m, a](HandRow& r) { r.excess_n = RunApproach(m, a).excess_n; }});
    }
  }
}

void AddWithdrawalCases(const DeviceModel& m, const cutting::Volume& block, bool quick,
                        HandCases* out) {
  for (const NamedBur& bur : WithdrawalBurs()) {
    for (Cut cut : kCuts) {
      for (bool turned : {false, true}) {
        for (double speed : {0.01, 0.03, 0.05}) {
          for (double hand : {0.0, 1000.0}) {
            if (quick && (speed < 0.05 || turned)) continue;
            Withdrawal w{bur.bur, cut, speed, turned, haptics::kDefaultLaw, hand};
            w.kc_n_per_m = m.kc_n_per_m;
            w.cell_m = m.resolution_m;
            w.peak_force_n = m.peak_force_n;
            const std::string name = std::string("withdraw-") + CutName(cut) + "-" + bur.name +
                                     (turned ? "-turned-" : "-") +
                                     std::to_string(std::lround(speed * 1e3)) + "mm_s";
            HandRow row = RowFor(m, kEnamel, name, {}, 0);
            if (hand > 0) row.hand_n_per_mm = hand * 1e-3;
            out->push_back({std::move(row), [w, &block](HandRow& r) {
                              r.pull_n = RunWithdrawal(w, block).opposing_n;
                            }});
          }
        }
      }
    }
  }
}

}  // namespace enamel::station::lab
