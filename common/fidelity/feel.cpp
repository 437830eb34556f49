#include "common/fidelity/feel.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/fidelity/tracks.h"
#include "common/haptics/coupling.h"
#include "common/haptics/uniform_material.h"

namespace enamel::fidelity {
namespace {

constexpr Threshold kThresholds[] = {
    {"force", kForceShare, "share",
     "Jones 1989, Perception 18:681; Pang, Tan and Durlach 1991, Perception & Psychophysics "
     "49:531"},
    {"viscosity", kViscosityShare, "share",
     "Jones, Hunter and Lafontaine 1997, Perception 26:1571"},
    {"delay", kDelay_s, "s",
     "Rank, Shi, Mueller and Hirche 2010, EuroHaptics, LNCS 6191, chapter 30"},
};

constexpr std::string_view kVerdictNames[kVerdictCount] = {
    "felt", "late", "nearly", "law_falls_short", "device_cannot", "beyond_force"};
constexpr std::string_view kVerdictWords[kVerdictCount] = {
    "as it is", "late", "nearly", "law falls short", "device cannot", "too weak"};

// A steady cut: long enough for a plain Maxwell spring to come within a tenth, 2.3 times the
// oracle's rise.
constexpr double kLeastCut_s = 2, kMostCut_s = 12, kRises = 3;
// Judged is the end of it, and never less than a twentieth.
constexpr double kJudgedShare = 0.4, kLeastJudgedShare = 0.05;
constexpr double kStroke_s = 1;
// The first stroke to and fro starts from rest; the others follow one like themselves.
constexpr double kStrokes_s = 6, kStrokesJudgedFrom_s = 2;
constexpr double kLongestLag_s = 0.75, kSample_s = 1e-3;
constexpr size_t kCoarse = 5;  // samples

// Off every cell's border, and on each axis by another share, so that the axes do not count as one.
const dvec3 kStart(3.3e-6, 2.1e-6, 1.1e-6);
const dvec3 kAlong = glm::normalize(dvec3(1, 2, 3));

// A hand's way along one line.
struct Way {
  Motion motion;
  double mean_m_per_s;

  double At(double t) const {
    if (motion == Motion::kSteady) return mean_m_per_s * t;
    double u = t / kStroke_s, whole = std::floor(u), s = MinimumJerk(u - whole);
    bool back = static_cast<int64_t>(whole) % 2 != 0;
    return mean_m_per_s * kStroke_s * (back ? 1 - s : s);
  }
  double SpeedAt(double t) const {
    if (motion == Motion::kSteady) return mean_m_per_s;
    double u = t / kStroke_s, whole = std::floor(u), rate = MinimumJerkRate(u - whole);
    bool back = static_cast<int64_t>(whole) % 2 != 0;
    return mean_m_per_s * (back ? -rate : rate);
  }
};

// Force along the motion's line and its distance from what is right, tick by tick.
struct Track {
  std::vector<double> along_n, error_n;
};
struct Run {
  std::vector<double> right_n;
  Track law, oracle;
};

double Right(const Tissue& tissue, double speed) {
  double size = RightForce_n(tissue, std::fabs(speed));
  return speed < 0 ? -size : size;
}

haptics::CouplingParams CouplingOf(const Device& d) {
  haptics::CouplingParams p;
  p.law.kind = haptics::kDefaultLaw;
  p.law.kc_n_per_m = d.kc_n_per_m;
  p.law.resolution_m = dvec3(d.resolution_m);
  p.law.tick_s = d.tick_s;
  p.peak_force_n = d.peak_force_n;
  p.delay_ticks = d.delay_ticks;
  return p;
}

// The force felt during tick k was computed `delay_ticks` earlier.
Run RunOf(const Device& d, const Tissue& tissue, const Way& way, size_t ticks) {
  haptics::Coupling coupling(CouplingOf(d));
  haptics::UniformMaterial material(Sym3::Isotropic(tissue.b_n_s_per_m));
  material.contact.coulomb_n = tissue.coulomb_n;
  material.contact.threshold_n = tissue.threshold_n;
  coupling.Reset(CellMiddle(kStart, d.resolution_m));
  auto delay = static_cast<size_t>(d.delay_ticks);
  Run out;
  std::vector<dvec3> computed(ticks), possible(ticks);
  dvec3 oracle(0);
  for (size_t k = 0; k < ticks; ++k) {
    // The force is held for the tick, so what is right is taken in its middle: half a tick of lag
    // would otherwise be held against every device alike.
    double now = static_cast<double>(k) * d.tick_s, middle = now + d.tick_s / 2;
    dvec3 tip = kStart + kAlong * way.At(now);
    computed[k] = -coupling.Tick(CellMiddle(tip, d.resolution_m), 1, material).force_sent_n;
    double speed = way.SpeedAt(middle), right = Right(tissue, speed);
    oracle = OracleStep(oracle, kAlong * right, d.kc_n_per_m * std::fabs(speed) * d.tick_s,
                        d.peak_force_n);
    possible[k] = oracle;
    out.right_n.push_back(right);
    auto Add = [&](const std::vector<dvec3>& all, Track* track) {
      dvec3 felt = k >= delay ? all[k - delay] : dvec3(0);
      track->along_n.push_back(Dot(felt, kAlong));
      track->error_n.push_back(glm::length(felt - kAlong * right));
    };
    Add(computed, &out.law);
    Add(possible, &out.oracle);
  }
  return out;
}

Figures OfSteady(const Device& d, const std::vector<double>& right, const Track& t) {
  Figures f;
  f.rise_s = -1;
  size_t n = right.size(), risen = n;
  for (size_t k = 0; k < n && risen == n; ++k) {
    if (std::fabs(t.along_n[k] - right[k]) <= kForceShare * right[k]) risen = k;
  }
  if (risen < n) f.rise_s = static_cast<double>(risen) * d.tick_s;
  auto before = [&](double share) {
    return n - static_cast<size_t>(share * static_cast<double>(n));
  };
  size_t from = before(kJudgedShare);
  if (risen < n) from = std::clamp(risen, from, before(kLeastJudgedShare));
  double error = 0, along = 0, wanted = 0;
  for (size_t k = from; k < n; ++k) {
    error += t.error_n[k];
    along += t.along_n[k];
    wanted += right[k];
  }
  f.error = error / wanted;
  f.gain = along / wanted;
  return f;
}

// The shift at which what is right, shifted, correlates best with the force. Both are taken over
// whole to-and-fro strokes, whose energy does not change with the shift: a window that shrank with
// it would move the peak by more than the threshold.
double LagOf(const Device& d, const std::vector<double>& right, const Track& t) {
  auto ticks_of = [&](double s) { return static_cast<size_t>(s / d.tick_s + 0.5); };
  // Looked at from two seconds on, so the longest shift never reaches before the first tick.
  size_t step = std::max<size_t>(1, ticks_of(kSample_s)), from = ticks_of(kStrokesJudgedFrom_s);
  auto samples = static_cast<size_t>(kLongestLag_s / (static_cast<double>(step) * d.tick_s));
  auto Correlation = [&](size_t shift) {
    double sum = 0;
    for (size_t k = from; k < right.size(); k += step)
      sum += t.along_n[k] * right[k - shift * step];
    return sum;
  };
  size_t best = 0;
  double most = Correlation(0);
  auto Try = [&](size_t shift) {
    double sum = Correlation(shift);
    if (sum <= most) return;
    most = sum;
    best = shift;
  };
  // The peak of strokes of a second is far broader than the coarse step: the best of these lies on
  // it.
  for (size_t shift = kCoarse; shift <= samples; shift += kCoarse) Try(shift);
  size_t middle = best;
  for (size_t shift = middle - std::min(middle, kCoarse - 1); shift < middle + kCoarse; ++shift)
    Try(shift);
  return static_cast<double>(best * step) * d.tick_s;
}

Figures OfStrokes(const Device& d, const std::vector<double>& right, const Track& t) {
  Figures f;
  double error = 0, product = 0, wanted = 0;
  auto from = static_cast<size_t>(kStrokesJudgedFrom_s / d.tick_s + 0.5);
  for (size_t k = from; k < right.size(); ++k) {
    error += t.error_n[k] * t.error_n[k];
    product += t.along_n[k] * right[k];
    wanted += right[k] * right[k];
  }
  f.error = std::sqrt(error / wanted);
  f.gain = product / wanted;
  f.lag_s = LagOf(d, right, t);
  return f;
}

double CutLength_s(const Device& d, const Tissue& tissue, double speed) {
  double rise = RightForce_n(tissue, speed) / (d.kc_n_per_m * speed);
  return std::clamp(kRises * rise, kLeastCut_s, kMostCut_s);
}

Result<Device> DeviceOf(const scene::DeviceProfile& p) {
  for (const auto& [field, number] :
       {std::pair{"resolution_nm", &p.resolution_nm},
        std::pair{"coupling_mn_per_mm", &p.coupling_mn_per_mm}, std::pair{"rate_hz", &p.rate_hz},
        std::pair{"peak_force_mn", &p.peak_force_mn}}) {
    if (number->value > 0) continue;
    return Status(Code::kInvalidInput,
                  "device profile '" + p.name + "': expected " + field + " above 0, found " +
                      std::to_string(number->value) + "; correct the profile",
                  field);
  }
  Device d;
  d.name = p.name;
  d.resolution_m = static_cast<double>(p.resolution_nm.value) * 1e-9;
  d.kc_n_per_m = static_cast<double>(p.coupling_mn_per_mm.value);  // mN/mm = N/m
  d.tick_s = 1 / static_cast<double>(p.rate_hz.value);
  d.delay_ticks = static_cast<int>(std::min(p.bus_delay_ticks.value, scene::kMostDelay_ticks));
  d.peak_force_n = static_cast<double>(p.peak_force_mn.value) * 1e-3;
  d.continuous_force_n = static_cast<double>(p.continuous_force_mn.value) * 1e-3;
  return d;
}

}  // namespace

std::span<const Threshold> Thresholds() { return kThresholds; }

std::string_view VerdictName(Verdict v) { return kVerdictNames[static_cast<size_t>(v)]; }
std::string_view VerdictWords(Verdict v) { return kVerdictWords[static_cast<size_t>(v)]; }
std::string_view MotionName(Motion m) { return m == Motion::kSteady ? "steady" : "strokes"; }

Result<Device> AsItStands(const scene::DeviceProfile& profile) { return DeviceOf(profile); }

Result<AttachedDevice> Attached(const scene::DeviceProfile& profile) {
  if (Result<Device> sound = DeviceOf(profile); !sound.ok()) return sound.status();
  AttachedDevice out;
  out.delay = scene::DelayOfAttached(profile, nullptr, profile.rate_hz.value);
  Result<scene::DeviceProfile> delayed =
      scene::WithDelay(profile, profile.rate_hz.value, out.delay.ticks);
  if (!delayed.ok()) return delayed.status();
  Result<Device> device = DeviceOf(*delayed);
  if (!device.ok()) return device.status();
  out.device = *device;
  return out;
}

bool HasMotors(const scene::DeviceProfile& profile) { return profile.name != "pointer"; }

Tissue TissueOf(const scene::TissueSpec& spec) {
  // mN s/mm = N s/m.
  return {std::string(cutting::TissueName(spec.tissue)),
          static_cast<double>(spec.damping_mn_s_per_mm), spec.coulomb_mn * 1e-3,
          spec.threshold_mn * 1e-3};
}

double RightForce_n(const Tissue& tissue, double speed) {
  if (speed <= 0) return 0;
  return std::max(tissue.threshold_n, tissue.coulomb_n + tissue.b_n_s_per_m * speed);
}

bool Holds(Motion motion, const Figures& f) {
  double delay = motion == Motion::kSteady ? f.rise_s : f.lag_s;
  return f.error <= kForceShare && delay >= 0 && delay <= kDelay_s;
}

Verdict VerdictOf(const Device& device, const Cell& cell) {
  // First: what the motors cannot give is no fault of the law or the coupling.
  if (cell.rms_n > device.continuous_force_n || cell.largest_n > device.peak_force_n)
    return Verdict::kBeyondForce;
  if (Holds(cell.motion, cell.law)) return Verdict::kFelt;
  if (cell.law.error <= kForceShare) return Verdict::kLate;
  if (cell.law.error <= kViscosityShare) return Verdict::kNearly;
  return Holds(cell.motion, cell.oracle) ? Verdict::kLawShort : Verdict::kDeviceCannot;
}

Cell Simulate(const Device& device, const Tissue& tissue, double speed, Motion motion) {
  bool steady = motion == Motion::kSteady;
  double duration = steady ? CutLength_s(device, tissue, speed) : kStrokes_s;
  Run run =
      RunOf(device, tissue, {motion, speed}, static_cast<size_t>(duration / device.tick_s + 0.5));
  Cell cell;
  cell.speed_m_per_s = speed;
  cell.motion = motion;
  double sum = 0;
  for (double right : run.right_n) {
    sum += right * right;
    cell.largest_n = std::max(cell.largest_n, std::fabs(right));
  }
  cell.rms_n = std::sqrt(sum / static_cast<double>(run.right_n.size()));
  auto FiguresOf = [&](const Track& track) {
    return steady ? OfSteady(device, run.right_n, track) : OfStrokes(device, run.right_n, track);
  };
  cell.law = FiguresOf(run.law);
  cell.oracle = FiguresOf(run.oracle);
  cell.verdict = VerdictOf(device, cell);
  return cell;
}

std::vector<Cell> MapOf(const Device& device, std::span<const Tissue> tissues) {
  std::vector<Cell> out;
  for (size_t i = 0; i < tissues.size(); ++i) {
    for (double speed : kSpeeds_m_per_s) {
      for (Motion motion : kMotions) {
        out.push_back(Simulate(device, tissues[i], speed, motion));
        out.back().tissue = i;
      }
    }
  }
  return out;
}

}  // namespace enamel::fidelity
