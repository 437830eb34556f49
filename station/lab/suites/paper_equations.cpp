#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/haptics/criteria.h"
#include "station/lab/suites/findings.h"
#include "station/lab/suites/paper_rows.h"

// Equations 1 to 17. Where the paper gives no number, the equation is evaluated on its Omega at the chosen B.
namespace enamel::station::lab {
namespace {

using haptics::LawKind;

constexpr char kCommand[] = "enamel-lab paper";
constexpr char kSuite[] = "enamel-lab qualify --profile all --suite paper";
// Grip of the hand in which a law may vibrate: a light one of the paper's kind, N/mm.
constexpr double kGrip_n_per_m = 1000;

struct Omega {
  const DeviceModel& model;
  double delta_m, rate_hz, b_n_s_per_m;
  double count_mm_per_s() const { return delta_m * rate_hz * 1e3; }
  double count_n() const { return b_n_s_per_m * delta_m * rate_hz; }
};

Measurement Cut(const Omega& o, LawKind law, HandKind hand, double speed_m_per_s,
                bool pass = false) {
  TrialSpec s = SpecOf(o.model, law, o.b_n_s_per_m, speed_m_per_s);
  s.hand = hand;
  s.hand_stiffness_n_per_m = kGrip_n_per_m;
  s.law.pass_through_at_rest = pass;
  s.settle_s = s.window_s = 1;
  s.measure_release = false;
  s.trace_s = o.model.tick_s();
  return RunTrial(s);
}

// Bounds that rounding stays within, at half of them.
PaperElement Bound(const std::string& element, const std::string& says, double printed,
                   double found, double unit_value, const char* unit) {
  PaperElement e{element,
                 says,
                 "",
                 "",
                 "a steady motion of 0.4 mm/s with tremor, rounded to counts",
                 PaperVerdict::kRemark,
                 "",
                 kCommand};
  e.printed = F(printed * unit_value, "%.3g ") + unit;
  e.ours = F(found * unit_value, "%.3g ") + unit;
  if (found > printed) {
    e.verdict = PaperVerdict::kContradicts;
    e.remark = "The bound does not hold.";
  } else {
    e.remark = "The bound holds. Rounding this motion to the nearest count reaches " +
               F(100 * found / printed, "%.0f %% of it.");
  }
  return e;
}

std::vector<PaperElement> OneToFour(const PrintedPaper& p, const Omega& o) {
  std::vector<PaperElement> out;
  const double v = p.figure8_mm_per_s * 1e-3, force = o.b_n_s_per_m * v;
  const Measurement ours = Cut(o, haptics::kDefaultLaw, HandKind::kVelocity, v);
  const double cell_n = o.model.kc_n_per_m * o.delta_m / 2;
  out.push_back({"equation 1", "F = B V",
                 F(force, "%.2f N") + F(p.figure8_mm_per_s, " at %.1f mm/s"),
                 F(ours.mean_n, "%.2f N"), "a prescribed motion, the Omega, our default law",
                 std::abs(ours.mean_n - force) <= cell_n ? PaperVerdict::kReproduced
                                                         : PaperVerdict::kNotReproducible,
                 "", kSuite});
  const double extracted =
      1e6 * Cut(o, LawKind::kPaperDamping, HandKind::kImpedance, v).extracted_j;
  const double of_ours = 1e6 * Cut(o, haptics::kDefaultLaw, HandKind::kImpedance, v).extracted_j;
  out.push_back({"equation 2", "F V <= 0 in every tick: the hand extracts no energy", "0 uJ",
                 F(of_ours, "%.1f uJ; ") + F(extracted, "eq. 1 alone %.0f uJ"),
                 F(kGrip_n_per_m * 1e-3,
                   "most energy that a hand of %.0f N/mm got out of the device in two seconds"),
                 of_ours < extracted ? PaperVerdict::kRemark : PaperVerdict::kContradicts,
                 "Tick by tick the condition is more than passivity needs, and no sampled law "
                 "meets it: a spring "
                 "gives back what it took. Ours bounds the sum over all ticks instead.",
                 kSuite});
  const RoundingErrors r = ErrorsOfRounding(o.delta_m, o.rate_hz, v);
  out.push_back(
      {"equation 3", "V = (p_i - p_i-1) f", F(o.count_mm_per_s(), "a count a tick: %.0f mm/s"),
       F(o.count_mm_per_s(), "%.0f mm/s, or 0 in ") + F(100 * r.at_rest, "%.1f %% of the ticks"),
       F(p.figure8_mm_per_s, "a motion of %.1f mm/s, rounded to counts"), PaperVerdict::kReproduced,
       "", kCommand});
  out.push_back({"equation 4", "V true = (p_i - p_i-1) f, of positions without error",
                 "a definition", "the simulator's speed", "the plant's own state",
                 PaperVerdict::kReproduced, "", kCommand});
  return out;
}

std::vector<PaperElement> FiveToFifteen(const PrintedPaper& p, const Omega& o) {
  std::vector<PaperElement> out;
  const RoundingErrors r = ErrorsOfRounding(o.delta_m, o.rate_hz, p.figure8_mm_per_s * 1e-3);
  out.push_back(
      Bound("equation 5", "|p measured - p| <= delta", 1, r.position, o.delta_m * 1e6, "um"));
  out.push_back(
      Bound("equation 6", "|dp measured - dp| <= 2 delta", 2, r.step, o.delta_m * 1e6, "um"));
  out.push_back(
      Bound("equation 7", "|V - V true| <= 2 delta f", 2, r.speed, o.count_mm_per_s(), "mm/s"));
  out.push_back(Bound("equation 8", "|F - F true| <= 2 B delta f", 2, r.force, o.count_n(), "N"));
  out.push_back(
      Bound("equation 9", "|w| <= 2 B delta f, w = F - F true", 2, r.force, o.count_n(), "N"));
  out.push_back({"equation 10", "dF_i = F_i - F_i-1", "a definition", "the same", "",
                 PaperVerdict::kReproduced, "", kCommand});
  const double factor = FactorOfSpeedChange(o.delta_m, o.rate_hz, 1e-3);
  const bool four = std::abs(factor - 4) < 0.01;
  PaperElement eleven =
      Bound("equation 11", "|dF| <= 4 B (f delta + |dV|)", 4, r.change, o.count_n(), "N");
  eleven.printed += " + 4 B |dV|";
  eleven.ours += F(factor, " + %.0f B |dV|");
  if (!four) {
    eleven.remark +=
        " dF = B (V_i - V_i-1) contains three positions, p_i - 2 p_i-1 + p_i-2, whose errors add "
        "up to 4 delta. That "
        "is the first 4. The true change of speed enters once, so the second 4 should be 1.";
  }
  out.push_back(eleven);
  const double rest = 1 - p.figure8_mm_per_s / o.count_mm_per_s();
  out.push_back(
      {"equation 12", "|dF / dp| <= K", F(o.model.max_stiffness_n_per_m * 1e-3, "%.0f N/mm"),
       F(100 * r.at_rest, "no value in %.1f %% of the ticks") +
           F(100 * rest, " (1 - V/(delta f) = %.1f %%)"),
       F(p.figure8_mm_per_s, "share of ticks with dp = 0 at %.1f mm/s"), PaperVerdict::kRemark,
       "The quotient has no value where the measured position did not change. At cutting speed "
       "that is "
       "nearly always.",
       kCommand});
  for (int i : {13, 14}) {
    PaperElement e =
        Bound("equation " + std::to_string(i),
              i == 13 ? "odd ticks: p measured = p + delta" : "even ticks: p measured = p - delta",
              1, r.position, o.delta_m * 1e6, "um");
    e.remark =
        "A worst case that is assumed. Rounding to the nearest count errs by half a count at most, "
        "and a slow motion "
        "does not alternate from tick to tick.";
    out.push_back(e);
  }
  // eq. 15 solved for B, beside eq. 16, at an acceleration as large as the quantisation's own term.
  const double a = 4 * o.delta_m * o.rate_hz * o.rate_hz, v = p.eq16_mm_per_s * 1e-3;
  const double k = o.model.max_stiffness_n_per_m;
  const double sixteen = haptics::PaperDampingBound(k, v, o.delta_m, o.rate_hz, a);
  const double fifteen =
      k * (v + 2 * o.delta_m * o.rate_hz) / (4 * o.delta_m * o.rate_hz * o.rate_hz + 4 * a);
  out.push_back({"equation 15", "4 B (f delta + |dV|) / (|dp| + 2 delta) <= K",
                 F(fifteen * 1e-3, "B <= %.5f N s/mm where a = 4 delta f^2"),
                 F(sixteen * 1e-3, "B <= %.5f, by eq. 16"), "solved for B, with a = f |dV|",
                 four ? PaperVerdict::kReproduced : PaperVerdict::kContradicts,
                 four ? ""
                      : "Solved for B, eq. 15 gives K (V + 2 delta f) / (4 delta f^2 + 4 a). Eq. "
                        "16 has a without the "
                        "4, and follows from eq. 11 with its second 4 taken out.",
                 kCommand});
  return out;
}

std::string Three(const std::vector<double>& values, const char* format) {
  std::string out;
  for (double v : values) out += (out.empty() ? "" : ", ") + F(v, format);
  return out;
}

PaperElement Sixteen(const PrintedPaper& p) {
  std::vector<double> printed, ours, without_speed;
  bool same = true, at_rest = true;
  for (const PrintedDevice& d : p.devices) {
    auto B = [&](double mm_per_s) {
      return 1e-3 * haptics::PaperDampingBound(d.max_stiffness_n_per_mm * 1e3, mm_per_s * 1e-3,
                                               d.resolution_mm * 1e-3, d.rate_hz, 0);
    };
    printed.push_back(d.table2_computed_n_s_per_mm);
    ours.push_back(B(p.eq16_mm_per_s));
    without_speed.push_back(B(0));
    // Within the paper's rounding: its figures have one to three digits.
    same = same && std::abs(ours.back() / printed.back() - 1) < 0.04;
    at_rest = at_rest && SameFigure(printed.back(), without_speed.back(), 1e-5);
  }
  return {"equation 16",
          "B <= K (V + 2 delta f) / (4 delta f^2 + a)",
          Three(printed, "%.5g") + " N s/mm",
          Three(ours, "%.5f") + " N s/mm",
          F(p.eq16_mm_per_s, "V = %.1f mm/s and a = 0, as in the paper; Omega, Phantom, BHhd"),
          !same     ? PaperVerdict::kNotReproducible
          : at_rest ? PaperVerdict::kRemark
                    : PaperVerdict::kReproduced,
          at_rest ? "The printed figures are those of V = 0 (" + Three(without_speed, "%.5g") +
                        "). Then delta drops out: B <= K T/2."
                  : "",
          kSuite};
}

PaperElement Seventeen(const PrintedPaper& p, const Omega& o) {
  const double v = p.figure8_mm_per_s * 1e-3, asked = o.b_n_s_per_m * v;
  const Measurement held = Cut(o, LawKind::kPaperLimited, HandKind::kVelocity, v);
  const Measurement passed = Cut(o, LawKind::kPaperLimited, HandKind::kVelocity, v, true);
  const Measurement ours = Cut(o, haptics::kDefaultLaw, HandKind::kVelocity, v);
  const bool either = std::abs(held.mean_n - asked) < p.figure8_error_n ||
                      std::abs(passed.mean_n - asked) < p.figure8_error_n;
  return {"equation 17",
          "F = F_i-1 + Kc dp where the slope of eq. 1 is steeper than Kc",
          F(asked, "%.2f N") + F(p.figure8_mm_per_s, " at %.1f mm/s (figure 8)"),
          F(held.mean_n, "%.2f N held where dp = 0, ") + F(passed.mean_n, "%.2f N passed; ") +
              F(ours.mean_n, "our default law %.2f N"),
          "a prescribed motion, the Omega, both readings of dp = 0",
          either ? PaperVerdict::kReproduced : PaperVerdict::kContradicts,
          either ? ""
                 : "Eq. 17 divides by dp dp, which is 0 in nearly every tick at this speed. If the "
                   "force is held there, "
                   "the law is a spring that rises to saturation. If eq. 1 is passed there, its "
                   "zeros are the force. "
                   "Neither gives figure 8.",
          kSuite};
}

}  // namespace

RoundingErrors ErrorsOfRounding(double delta, double rate_hz, double speed_m_per_s) {
  // 10 Hz and 20 um: physiological tremor of a supported hand, after common/fidelity/hands.h.
  constexpr double kTremor_m = 20e-6, kTremor_hz = 10;
  constexpr int kTicks = 20'000;
  RoundingErrors out;
  double p[3] = {0, 0, 0}, e[3] = {0, 0, 0}, measured_before = 0;
  int rest = 0, ticks = 0;
  for (int i = 0; i < kTicks; ++i) {
    const double t = i / rate_hz;
    p[2] = p[1], p[1] = p[0], e[2] = e[1], e[1] = e[0];
    p[0] = speed_m_per_s * t + kTremor_m * std::sin(2 * std::numbers::pi * kTremor_hz * t);
    const double measured = delta * std::round(p[0] / delta);
    e[0] = (measured - p[0]) / delta;
    out.position = std::max(out.position, std::abs(e[0]));
    if (i >= 1) {
      out.step = std::max(out.step, std::abs(e[0] - e[1]));
      // Speed and force are the step times f and B f: the same multiple of their units.
      out.speed = out.force = out.step;
    }
    if (i >= 2) out.change = std::max(out.change, std::abs(e[0] - 2 * e[1] + e[2]));
    // The share at rest is the steady motion's, without the tremor.
    const double steady = delta * std::round(speed_m_per_s * t / delta);
    if (i >= 1) {
      ++ticks;
      rest += steady == measured_before;
    }
    measured_before = steady;
  }
  out.at_rest = static_cast<double>(rest) / ticks;
  return out;
}

double FactorOfSpeedChange(double delta, double rate_hz, double speed_change_m_per_s) {
  // Three true positions with that change of speed, each wrong by one delta to either side.
  const double change = speed_change_m_per_s / rate_hz;
  double worst = 0;
  for (int corner = 0; corner < 8; ++corner) {
    auto Error = [&](int bit) { return (corner >> bit & 1) ? delta : -delta; };
    worst = std::max(worst, std::abs(change + Error(0) - 2 * Error(1) + Error(2)) * rate_hz);
  }
  return (worst - 4 * rate_hz * delta) / speed_change_m_per_s;
}

std::vector<PaperElement> PaperEquations(const PrintedPaper& p,
                                         const std::vector<DeviceModel>& devices) {
  const Omega o{devices[0], p.devices[0].resolution_mm * 1e-3, p.devices[0].rate_hz,
                p.b_n_s_per_mm * 1e3};
  std::vector<PaperElement> out = OneToFour(p, o);
  for (PaperElement& e : FiveToFifteen(p, o)) out.push_back(std::move(e));
  out.push_back(Sixteen(p));
  out.push_back(Seventeen(p, o));
  return out;
}

}  // namespace enamel::station::lab
