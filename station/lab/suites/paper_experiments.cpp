#include <algorithm>
#include <cmath>

#include "common/haptics/criteria.h"
#include "station/lab/laws/stability.h"
#include "station/lab/suites/findings.h"
#include "station/lab/suites/paper_rows.h"
#include "station/lab/suites/suite_paper.h"

// The measured cutting, tables 1 to 3 and figures 7 to 9.
namespace enamel::station::lab {
namespace {

constexpr char kCommand[] = "enamel-lab paper";
constexpr char kSuite[] = "enamel-lab qualify --profile all --suite paper";
// A device's own damping, N s/m, which the paper does not print: the range of such devices.
constexpr double kMinOwn = 0.5, kMaxOwn = 8;

PaperElement MeasuredCutting(const PrintedPaper& p) {
  PaperElement e{"measured cutting",
                 "12 dentists, 40 teeth: largest force, range of B, largest speed",
                 "",
                 "",
                 "each largest force over its range of B is a range of speeds",
                 PaperVerdict::kRemark,
                 "",
                 kCommand};
  bool possible = true;
  std::string larger;
  for (const PrintedTissue& t : p.tissues) {
    auto Add = [](std::string* to, const std::string& what) {
      *to += (to->empty() ? "" : "; ") + what;
    };
    const double middle = (t.least_b_n_s_per_mm + t.most_b_n_s_per_mm) / 2;
    Add(&e.printed, t.name + F(t.force_n, " %.1f N, B ") + F(t.least_b_n_s_per_mm, "%.1f to ") +
                        F(t.most_b_n_s_per_mm, "%.1f N s/mm"));
    Add(&e.ours, t.name + F(t.force_n / t.most_b_n_s_per_mm, " F/B = %.2f to ") +
                     F(t.force_n / t.least_b_n_s_per_mm, "%.2f mm/s"));
    Add(&larger, F(middle * p.speed_mm_per_s, "%.1f N in ") + t.name);
    possible = possible && t.force_n / t.most_b_n_s_per_mm <= p.speed_mm_per_s;
  }
  e.printed += F(p.speed_mm_per_s, "; up to %.2f mm/s");
  if (!possible) {
    e.verdict = PaperVerdict::kContradicts;
    e.remark = "The largest force needs a speed above the largest that was measured.";
  } else {
    e.remark = "B V at the middle of each range and the largest speed would be " + larger +
               ", more than was measured. So the dentists did not press hardest where they moved "
               "fastest: the largest "
               "force, B and speed are of different cuts.";
  }
  return e;
}

PlantSpec PlantOf(const PrintedDevice& d, const DeviceModel& m, double own_damping) {
  PlantSpec s;
  s.mass_kg = m.mass_kg;
  s.damping_n_s_per_m = own_damping;
  s.friction_n = m.friction_n;
  s.resolution_m = d.resolution_mm * 1e-3;
  s.tick_s = 1 / d.rate_hz;
  s.substeps = 1;
  return s;
}

PaperElement TableOne(const PrintedPaper& p, const PrintedDevice& d, const DeviceModel& m) {
  const double least = 1e-3 * LargestPassive(PlantOf(d, m, kMinOwn), Rendered::kDamper);
  const double most = 1e-3 * LargestPassive(PlantOf(d, m, kMaxOwn), Rendered::kDamper);
  const double speed_mm_per_s = d.table1_force_n / d.table1_b_n_s_per_mm;
  PaperElement e{std::string("table 1, ") + d.name,
                 "largest B and force at which eq. 1 alone is stable",
                 F(d.table1_b_n_s_per_mm, "%.4f N s/mm, ") + F(d.table1_force_n, "%.2f N"),
                 F(least, "%.4f to ") + F(most, "%.4f N s/mm; ") +
                     F(d.table1_b_n_s_per_mm * p.speed_mm_per_s, "%.4f N at ") +
                     F(p.speed_mm_per_s, "%.2f mm/s"),
                 F(kMinOwn, "passive limit of a simulated device whose own damping is %.1f to ") +
                     F(kMaxOwn, "%.0f N s/m"),
                 PaperVerdict::kNotReproducible,
                 "",
                 kSuite};
  const bool inside = d.table1_b_n_s_per_mm >= least && d.table1_b_n_s_per_mm <= most;
  if (speed_mm_per_s <= p.speed_mm_per_s && inside) {
    e.verdict = PaperVerdict::kRemark;
    e.remark = "The device's own damping, which decides the limit, is not printed.";
    return e;
  }
  e.remark = std::string(inside ? "The printed B lies in that range"
                                : "The printed B is outside that range") +
             ". Where in the range depends on the device's own damping, which is not printed. The "
             "printed force is B V at " +
             F(speed_mm_per_s, "%.0f mm/s, ") +
             F(speed_mm_per_s / p.speed_mm_per_s, "%.0f times the largest cutting speed.");
  return e;
}

PaperElement TableTwo(const PrintedPaper& p, const PrintedDevice& d) {
  auto B = [&](double mm_per_s) {
    return 1e-3 * haptics::PaperDampingBound(d.max_stiffness_n_per_mm * 1e3, mm_per_s * 1e-3,
                                             d.resolution_mm * 1e-3, d.rate_hz, 0);
  };
  PaperElement e{std::string("table 2, ") + d.name,
                 "largest B measured, and by eq. 16",
                 F(d.table2_measured_n_s_per_mm, "%.4f measured, ") +
                     F(d.table2_computed_n_s_per_mm, "%.5g computed"),
                 F(B(0), "%.5f at rest, ") + F(B(p.eq16_mm_per_s), "%.5f at ") +
                     F(p.eq16_mm_per_s, "%.1f mm/s"),
                 "eq. 16",
                 PaperVerdict::kReproduced,
                 "",
                 kSuite};
  if (!SameFigure(d.table2_computed_n_s_per_mm, B(0), 1e-5) &&
      std::abs(B(p.eq16_mm_per_s) / d.table2_computed_n_s_per_mm - 1) > 0.04) {
    e.verdict = PaperVerdict::kNotReproducible;
    e.remark = "Eq. 16 gives another figure.";
  } else if (d.table1_b_n_s_per_mm != d.table2_measured_n_s_per_mm) {
    e.verdict = PaperVerdict::kContradicts;
    e.remark = F(d.table1_b_n_s_per_mm, "Table 1 prints %.4f for the same measurement") +
               F(d.table2_measured_n_s_per_mm, ", table 2 %.4f, and the text 0.002.");
  } else {
    e.verdict = PaperVerdict::kRemark;
    e.remark = F(100 * (d.table2_measured_n_s_per_mm / d.table2_computed_n_s_per_mm - 1),
                 "The measured B is %+.0f %% from the computed. Eq. 16 is K T/2 here: it says of a "
                 "device no more than "
                 "its K.");
  }
  return e;
}

PaperElement TableThree(const PrintedPaper& p, const PrintedDevice& d, const DeviceModel& m) {
  const double kc = d.table3_kc_n_per_mm * 1e3;
  const Table3Says says =
      ArithmeticOfTable3(d.table3_force_n, kc, d.resolution_mm * 1e-3, 1 / d.rate_hz);
  const double after = LimiterForceAfter(m, says.way_m),
               later = LimiterForceAfter(m, 2 * says.way_m);
  PaperElement e{std::string("table 3, ") + d.name,
                 "largest continuous force with eq. 17",
                 F(d.table3_force_n, "%.1f N at > ") + F(p.table3_mm_per_s, "%.0f mm/s, Kc ") +
                     F(d.table3_kc_n_per_mm, "%.3g N/mm"),
                 F(after, "%.1f N after ") + F(says.way_m * 1e3, "%.2f mm, ") +
                     F(later, "%.1f N after twice that way"),
                 F(p.table3_mm_per_s, "eq. 17 in a hand that prescribes %.0f mm/s, B = ") +
                     F(p.b_n_s_per_mm, "%.1f N s/mm"),
                 PaperVerdict::kReproduced,
                 "",
                 kSuite};
  // Continuous: it stays what it is.
  if (std::abs(later - d.table3_force_n) <= 0.1 * d.table3_force_n) return e;
  e.verdict = PaperVerdict::kNotReproducible;
  e.remark = F(p.b_n_s_per_mm * p.table3_mm_per_s,
               "Eq. 1 asks for %.0f N, so eq. 17 stays on its slope Kc, passes the "
               "printed force and rises until the motors' limit. ");
  const double eight = p.b_n_s_per_mm * p.figure8_mm_per_s;
  if (std::string(d.profile) == "omega3" && says.force_at_figure_8_n < eight - p.figure8_error_n) {
    e.verdict = PaperVerdict::kContradicts;
    e.remark += F(says.largest_b_n_s_per_m * 1e-3,
                  "If eq. 1 itself stopped there, B would be at most %.2f N s/mm, which "
                  "gives ") +
                F(says.force_at_figure_8_n, "%.2f N where figure 8 shows ") + F(eight, "%.1f N.");
  } else {
    e.remark += "What stopped it is not printed.";
  }
  return e;
}

Measurement Default(const DeviceModel& m, const PrintedPaper& p, double mm_per_s) {
  TrialSpec s = SpecOf(m, haptics::kDefaultLaw, p.b_n_s_per_mm * 1e3, mm_per_s * 1e-3);
  s.measure_release = false;
  return RunTrial(s);
}

std::vector<PaperElement> Figures(const PrintedPaper& p, const DeviceModel& omega) {
  std::vector<PaperElement> out;
  PaperElement seven{"figure 7",
                     "force of eq. 17 at two speeds, the Omega",
                     "",
                     "",
                     "our default law, prescribed motion",
                     PaperVerdict::kRemark,
                     "The paper says that the force is close to that of a real cut and prints no "
                     "numbers. The real cut is "
                     "taken to be B V.",
                     kSuite};
  for (double v : p.figure7_mm_per_s) {
    const Measurement found = Default(omega, p, v);
    auto Add = [&](std::string* to, const std::string& what) {
      *to += (to->empty() ? "" : "; ") + what;
    };
    Add(&seven.printed, F(p.b_n_s_per_mm * v, "B V = %.2f N at ") + F(v, "%.1f mm/s"));
    Add(&seven.ours, F(found.mean_n, "%.2f N"));
    if (!(found.error_max_n < p.figure8_error_n)) {
      seven.verdict = PaperVerdict::kNotReproducible;
      seven.remark = F(found.error_max_n, "Our law is off by %.2f N.");
    }
  }
  out.push_back(seven);
  const Measurement eight = Default(omega, p, p.figure8_mm_per_s);
  const bool within = eight.error_max_n < p.figure8_error_n;
  out.push_back(
      {"figure 8", "force measured in a tooth beside force computed, the Omega, 0.4 mm/s",
       F(p.figure8_error_n, "they differ by less than %.1f N"),
       F(eight.error_max_n, "by at most %.3f N from B V = ") +
           F(p.b_n_s_per_mm * p.figure8_mm_per_s, "%.2f N"),
       "our default law, prescribed motion, largest error per axis",
       within ? PaperVerdict::kRemark : PaperVerdict::kNotReproducible,
       F(omega.friction_n,
         "Of the force sent. The device's own friction adds up to %.2f N to what the hand "
         "feels. The paper's measured curve is not given as numbers."),
       kSuite});
  const Measurement nine = Default(omega, p, p.table3_mm_per_s);
  const bool same = std::abs(nine.mean_n - p.figure9_n) < 0.1 * p.figure9_n;
  out.push_back(
      {"figure 9", "largest force of the Omega with the damping model", F(p.figure9_n, "%.1f N"),
       F(nine.mean_n, "%.1f N at ") + F(p.table3_mm_per_s, "%.0f mm/s"),
       "our default law, prescribed motion",
       same ? PaperVerdict::kReproduced : PaperVerdict::kNotReproducible,
       same ? ""
            : F(omega.peak_force_n,
                "Ours reaches the motors' limit, %.0f N. What stops at the printed force is "
                "the question of table 3."),
       kSuite});
  return out;
}

}  // namespace

bool SameFigure(double printed, double ours, double unit) {
  return std::abs(printed - ours) <= unit / 2;
}

std::vector<PaperElement> PaperExperiments(const PrintedPaper& p,
                                           const std::vector<DeviceModel>& devices) {
  std::vector<PaperElement> out = {MeasuredCutting(p)};
  for (size_t i = 0; i < p.devices.size(); ++i)
    out.push_back(TableOne(p, p.devices[i], devices[i]));
  for (const PrintedDevice& d : p.devices) out.push_back(TableTwo(p, d));
  for (size_t i = 0; i < p.devices.size(); ++i)
    out.push_back(TableThree(p, p.devices[i], devices[i]));
  for (PaperElement& e : Figures(p, devices[0])) out.push_back(std::move(e));
  return out;
}

const char* NameOf(PaperVerdict verdict) {
  switch (verdict) {
    case PaperVerdict::kReproduced:
      return "reproduced";
    case PaperVerdict::kRemark:
      return "reproduced with a remark";
    case PaperVerdict::kContradicts:
      return "contradicts itself";
    case PaperVerdict::kNotReproducible:
      return "not reproducible from what is printed";
  }
  return "";
}

std::vector<PaperElement> PaperElements(const PrintedPaper& printed) {
  std::vector<DeviceModel> devices;
  for (const PrintedDevice& d : printed.devices) {
    for (const scene::DeviceProfile& profile : ShippedProfiles()) {
      if (profile.name != d.profile) continue;
      DeviceModel m = *ModelOf(profile);
      // The paper's own setting: its K, its Kc, its rate and its cells.
      m.resolution_m = d.resolution_mm * 1e-3;
      m.max_stiffness_n_per_m = d.max_stiffness_n_per_mm * 1e3;
      m.kc_n_per_m = d.table3_kc_n_per_mm * 1e3;
      m.rate_hz = d.rate_hz;
      devices.push_back(m);
    }
  }
  std::vector<PaperElement> out = PaperEquations(printed, devices);
  for (PaperElement& e : PaperExperiments(printed, devices)) out.push_back(std::move(e));
  return out;
}

}  // namespace enamel::station::lab
