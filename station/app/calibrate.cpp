#include "station/app/calibrate.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <limits>
#include <ratio>

#include "common/base/file.h"
#include "common/base/unix_time.h"
#include "common/haptics/criteria.h"
#include "common/program/log.h"
#include "common/program/output.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/cell.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "common/scene/own_friction.h"
#include "common/scene/rate.h"
#include "station/app/measured_device.h"
#include "station/devices/operators.h"
#include "station/loop/realtime.h"
#include "station/session/device_delay.h"
#include "station/session/stop_signals.h"
#include "station/uplink/credentials.h"
#include "station/uplink/server_link.h"

namespace enamel::station {
namespace {

// Share of the smallest bound: the measured numbers have intervals, and a device changes with
// warmth and wear.
constexpr double kMargin = 0.9;

Result<MeasuredDevice> OpenSimulated(const CalibrateCommand& options) {
  MeasuredDevice out;
  auto truth = scene::FindProfile(options.device.substr(kSimulated.size()));
  ENAMEL_RETURN_IF_ERROR(truth.status());
  ENAMEL_ASSIGN_OR_RETURN(auto profile,
                          options.profile.empty() ? truth : scene::FindProfile(options.profile));
  core::CoreParams params;
  params.rate_hz = static_cast<uint32_t>(options.rate_hz);
  params.resolution_nm.fill(scene::CountNm(*truth));
  params.peak_force_mn = static_cast<int32_t>(truth->peak_force_mn.value);
  PlantParams plant = PlantOf(*truth, params);
  // Nobody holds it, as with a real device.
  plant.hand_mass_kg = 0;
  plant.delay_ticks =
      static_cast<int>(std::min<int64_t>(truth->bus_delay_ticks.value, SimulatedDevice::kMaxDelay));
  out.count_m.fill(plant.count_m);
  out.device = std::make_unique<SimulatedDevice>(plant, std::make_unique<NobodyHolding>());
  out.profile = std::move(profile);
  out.address = options.device;
  return out;
}

void ShowProgress(const Calibrator& calibrator, std::string& last) {
  std::string doing = calibrator.Doing();
  if (doing == last || program::LogIsJson()) return;
  last = doing;
  std::fprintf(stderr, "%3.0f %%  %s\n", 100 * calibrator.progress(), doing.c_str());
}

Result<std::array<AxisFigures, 3>> Measure(MeasuredDevice& subject,
                                           const CalibrateCommand& options) {
  CalibratorSetup setup;
  setup.count_m = subject.count_m;
  setup.tick_s = 1.0 / options.rate_hz;
  setup.max_force_n = std::min(options.max_force_n,
                               static_cast<double>(subject.profile.peak_force_mn.value) * 1e-3);
  Calibrator calibrator(setup);
  // A simulated device's time passes with each Step; nothing has to be punctual.
  if (subject.real) {
    RealtimeGrant grant = RequestRealtime();
    if (!grant.refused.empty()) program::SayWarning(grant.refused);
  }
  std::string shown;
  int64_t due_ns = Now_ns();
  CatchStopSignals();
  while (!calibrator.done() && StopsAsked() == 0) {
    if (subject.real) SleepUntil(due_ns += std::nano::den / options.rate_hz);
    ShowProgress(calibrator, shown);
    subject.device->SendForce(calibrator.Step(subject.device->ReadSample()));
  }
  // Otherwise the device would hold the last force until its watchdog ends it.
  subject.device->SendForce(dvec3(0));
  if (!calibrator.done()) {
    return Status(Code::kUnavailable, "stopped before the end: nothing was measured");
  }
  return calibrator.Figures();
}

// Asks the person to let go and confirm; a pipe cannot.
Status AwaitGoAhead(const CalibrateCommand& options, const MeasuredDevice& subject) {
  if (!subject.real || options.yes) return Status::Ok();
  if (::isatty(STDIN_FILENO) == 0) {
    return Status(Code::kInvalidInput,
                  "the device will move by itself: run this on a terminal, or add --yes when "
                  "nobody is near it",
                  "yes");
  }
  std::printf(
      "%s will move by itself, about a centimetre each way, for a minute and a half.\n"
      "  1. Put its arm in the middle of its reach, balanced or on a rest that lets it move.\n"
      "  2. Take everybody's hands off it.\n"
      "  3. Press Enter. Ctrl-C stops it at any time: the force is then 0.\n",
      subject.device->Name().c_str());
  std::string line;
  std::getline(std::cin, line);
  return Status::Ok();
}

// An estimate of a small number may be below 0; a document holds possible values only.
int64_t Rounded(double v) { return std::llround(std::max(0.0, v)); }

scene::Measured Document(const Estimate& e, double unit) {
  return {Rounded(e.value / unit), Rounded(e.uncertainty / unit), std::max<int64_t>(1, e.samples)};
}

void Print(const AxisFigures& worst, const std::array<AxisFigures, 3>& axes,
           const scene::DeviceProfile& profile) {
  std::printf("%-14s %10s %10s %10s   %-18s %s\n", "", "x", "y", "z", "worst, 95 %", "profile");
  auto line = [&](const char* what, const char* unit, double scale, Estimate AxisFigures::*member,
                  int64_t documented, double document_unit) {
    const Estimate& w = worst.*member;
    std::printf("%-14s %10.4g %10.4g %10.4g   %.4g +- %.2g %s", what,
                (axes[0].*member).value / scale, (axes[1].*member).value / scale,
                (axes[2].*member).value / scale, w.value / scale, w.uncertainty / scale, unit);
    if (document_unit > 0) {
      std::printf("   (%.4g)", static_cast<double>(documented) * document_unit / scale);
    }
    std::printf("\n");
  };
  line("cell", "um", 1e-6, &AxisFigures::resolution_m, profile.resolution_nm.value, 1e-9);
  line("noise", "um", 1e-6, &AxisFigures::noise_m, 0, 0);
  line("friction c", "N", 1, &AxisFigures::friction_n, profile.friction_mn.value, 1e-3);
  line("damping b", "N s/m", 1, &AxisFigures::damping_n_s_per_m, profile.damping_mn_s_per_m.value,
       1e-3);
  line("mass", "g", 1e-3, &AxisFigures::mass_kg, profile.mass_g.value, 1e-3);
  line("bus delay", "ticks", 1, &AxisFigures::delay_ticks, profile.bus_delay_ticks.value, 1);
  if (worst.mode_hz.value > 0) line("first mode", "Hz", 1, &AxisFigures::mode_hz, 0, 0);
  std::printf("encoders count %s\n", worst.joints ? "at the joints" : "along the axes");
}

// Where attempts on this unit find its delay (device_delay.h).
Status KeepForAttempts(const CalibrateCommand& options, const scene::Calibration& document,
                       const MeasuredDevice& subject) {
  const std::string unit = subject.device->Unit();
  // Only for units with a serial number: two boards of one model differ in their delay.
  if (unit.empty()) {
    std::printf(
        "it has no serial number, which would distinguish it from others of its model: attempts on "
        "it rely on its profile\n");
    return Status::Ok();
  }
  std::error_code error;
  std::filesystem::create_directories(CalibrationsFolder(options.data), error);
  const auto file = CalibrationFile(options.data, unit);
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(file, AsBytes(scene::ToJson(document))));
  std::printf("attempts on this unit are computed with %lld ticks of delay from now on: %s\n",
              static_cast<long long>(document.bus_delay_ticks->value), file.c_str());
  return Status::Ok();
}

std::string Today() {
  std::time_t now = std::time(nullptr);
  char text[16] = {};
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

}  // namespace

void RaiseToAnswers(Estimate& delay_ticks, const scene::AnswerTime& answers, int rate_hz) {
  const int64_t ticks = scene::AnswerTicks(answers, rate_hz);
  if (WholeTicks(delay_ticks) < ticks)
    delay_ticks = {static_cast<double>(ticks), 0, answers.answers};
}

void NoteAnswers(scene::Calibration& document, const scene::AnswerTime& answers) {
  const int64_t samples = std::max<int64_t>(answers.answers, 1);
  document.answer_us = scene::Measured{answers.median_us, answers.median_half_us, samples};
  document.answer_jitter_us =
      scene::Measured{answers.jitter_us(), answers.median_half_us + answers.p99_half_us, samples};
}

AxisFigures WorstOf(const std::array<AxisFigures, 3>& axes) {
  AxisFigures out = axes[0];
  auto take = [&](Estimate AxisFigures::*member, bool largest) {
    for (const AxisFigures& a : axes) {
      bool worse = largest ? (a.*member).value > (out.*member).value
                           : (a.*member).value < (out.*member).value;
      if (worse) out.*member = a.*member;
    }
  };
  // The worst for stability: large cells, mass and delay, little friction and damping. One profile
  // must hold on every axis.
  take(&AxisFigures::resolution_m, true);
  take(&AxisFigures::noise_m, true);
  take(&AxisFigures::friction_n, false);
  take(&AxisFigures::damping_n_s_per_m, false);
  take(&AxisFigures::mass_kg, true);
  take(&AxisFigures::delay_ticks, true);
  for (const AxisFigures& a : axes) out.count_m = std::max(out.count_m, a.count_m);
  // Of the axes that have one.
  for (const AxisFigures& a : axes) {
    const bool lower = out.mode_hz.value == 0 || a.mode_hz.value < out.mode_hz.value;
    if (a.mode_hz.value > 0 && lower) out.mode_hz = a.mode_hz;
  }
  return out;
}

Result<scene::DeviceProfile> ProposeProfile(const AxisFigures& worst, int rate_hz,
                                            const scene::DeviceProfile& base,
                                            const std::string& name, const std::string& source) {
  auto low = [](const Estimate& e) { return std::max(0.0, e.value - e.uncertainty); };
  // At the lower ends of their intervals: a value that may be zero is not relied on.
  double b = low(worst.damping_n_s_per_m), c = low(worst.friction_n);
  double passive = PassiveStiffness(b, 1.0 / rate_hz, worst.delay_ticks);
  // The core uses whole ticks, and its clause must hold for those too.
  const int64_t ticks = WholeTicks(worst.delay_ticks);
  scene::DeviceProfile p = base;
  p.resolution_nm = {Rounded(worst.resolution_m.value * 1e9), source};
  p.mass_g = {std::max<int64_t>(1, Rounded(worst.mass_kg.value * 1e3)), source};
  p.cell.reset();
  const auto count_nm = static_cast<int32_t>(Rounded(worst.count_m * 1e9));
  if (worst.joints || count_nm != p.resolution_nm.value) {
    // An encoder at rest is off by a count where its noise is wider than its cell.
    const int noise = worst.noise_m.value > 0.5 * worst.resolution_m.value ? 1 : 0;
    p.cell = scene::CellSpec{worst.joints, count_nm, noise, source};
  }
  p.structural_mode_hz = {};
  double structure = std::numeric_limits<double>::infinity();
  if (worst.mode_hz.value > 0) {
    p.structural_mode_hz = {std::max<int64_t>(1, static_cast<int64_t>(low(worst.mode_hz))),
                            source + ", lower end of its interval"};
    structure = static_cast<double>(scene::ModeStiffness_mn_per_mm(p));
  }
  const double beside_damping = std::min(c / (scene::CellSupportNm(p) * 1e-9), structure);
  double kc =
      kMargin *
      std::min({passive, haptics::CouplingStiffness(b, 1.0 / rate_hz, static_cast<int>(ticks)),
                beside_damping});
  std::string kc_source =
      "nine tenths of the least of 2 b f/(d + 1)^2, c/S and m (2 pi f1/4)^2, measured";
  if (p.board_spring) {
    const double carried =
        haptics::CouplingStiffness(b, 1.0 / p.board_spring->rate_hz, p.board_spring->delay_ticks);
    const auto on_board = static_cast<double>(base.coupling_mn_per_mm.value);
    if (on_board <= std::min(carried, beside_damping)) {
      kc = on_board;
      kc_source = base.coupling_mn_per_mm.source;
      passive = carried;
    } else {
      p.board_spring.reset();
      kc_source += ": the station runs the spring, as the board's own of " +
                   std::to_string(base.coupling_mn_per_mm.value) + " mN/mm is above it";
    }
  }
  // Not `kc < 1`: this also refuses a NaN among the figures.
  if (!(kc >= 1)) {
    return Status(
        Code::kInvalidInput,
        "no coupling would be stable on this device: it needs friction and damping of its "
        "own, found c = " +
            std::to_string(c) + " N and b = " + std::to_string(b) +
            " N s/m at the lower ends of their intervals",
        "coupling_mn_per_mm");
  }
  p.name = name;
  p.title = base.title + ", measured";
  p.damping_mn_s_per_m = {Rounded(b * 1e3), source + ", lower end of its interval"};
  p.friction_mn = {Rounded(c * 1e3), source + ", lower end of its interval"};
  p.bus_delay_ticks = {ticks, source + ", rounded up"};
  p.max_stiffness_mn_per_mm = {std::max<int64_t>(1, Rounded(passive)),
                               "2 b f/(d + 1)^2 of the measured b and d, d with its fraction and "
                               "at the upper end of its interval"};
  p.coupling_mn_per_mm = {static_cast<int64_t>(kc), std::move(kc_source)};
  p.rate_hz = {rate_hz, source};
  p.electrical_damping_mn_s_per_m = {};  // included in the measured b
  // Rotation is not measured; its stiffness is only lowered to the limit of the measured delay.
  if (p.torque) {
    scene::Sourced& k = p.torque->coupling_un_m_per_rad;
    const int64_t most = scene::PassiveTorque_un_m_per_rad(p, rate_hz, ticks);
    if (most < k.value) k = {most, "2 b_rot f/(d + 1)^2 with the measured d"};
  }
  return p;
}

scene::Calibration CalibrationOf(const AxisFigures& worst, int rate_hz) {
  scene::Calibration out;
  out.rate_hz = rate_hz;
  out.method =
      "Rest 2 s: noise. Eight pushes per axis: delay, with a structural mode where there is one. "
      "Swings of 0.5, 1, 2 and 4 Hz per axis by its "
      "own motors, nobody holding it: mass, damping and friction from the fundamentals of "
      "position, "
      "force and direction. Cell: steps between neighbouring counts, or moves of one joint's "
      "count. station/devices/calibrator.h";
  out.resolution_nm = Document(worst.resolution_m, 1e-9);
  out.noise_nm = Document(worst.noise_m, 1e-9);
  out.friction_mn = Document(worst.friction_n, 1e-3);
  out.damping_mn_s_per_m = Document(worst.damping_n_s_per_m, 1e-3);
  out.mass_g = Document(worst.mass_kg, 1e-3);
  out.bus_delay_ticks =
      scene::Measured{WholeTicks(worst.delay_ticks), Rounded(worst.delay_ticks.uncertainty),
                      std::max<int64_t>(1, worst.delay_ticks.samples)};
  if (worst.mode_hz.value > 0) out.structural_mode_hz = Document(worst.mode_hz, 1);
  return out;
}

Status CalibrateDevice(const CalibrateCommand& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.out, "--out"));
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.calibration, "--calibration"));
  ENAMEL_ASSIGN_OR_RETURN(auto subject,
                          options.device.starts_with(kSimulated)
                              ? OpenSimulated(options)
                              : OpenToMeasure(options.device, options.profile, options.rate_hz));
  // Reports a name that the document does not allow before anything moves.
  scene::DeviceProfile named = subject.profile;
  named.name = options.name.empty() ? subject.profile.name + "-measured" : options.name;
  if (auto valid = scene::ProfileFromJson(scene::ToJson(named)); !valid.ok()) return valid.status();
  ENAMEL_RETURN_IF_ERROR(AwaitGoAhead(options, subject));
  ENAMEL_ASSIGN_OR_RETURN(auto axes, Measure(subject, options));
  AxisFigures worst = WorstOf(axes);
  std::string answers;
  const auto time = subject.device->answer_time();
  if (time) {
    RaiseToAnswers(worst.delay_ticks, *time, options.rate_hz);
    answers = "; " + AnswersText(*time);
  }
  Print(worst, axes, subject.profile);
  if (!answers.empty()) std::printf("%s\n", answers.c_str() + 2);

  auto proposed = ProposeProfile(worst, options.rate_hz, subject.profile, named.name,
                                 "measured " + Today() + " on " + subject.address);
  scene::Calibration document = CalibrationOf(worst, options.rate_hz);
  if (time) NoteAnswers(document, *time);
  document.device = subject.address;
  document.profile = subject.profile.name;
  if (auto station = LoadCredentials(options.data); station.ok()) document.station = station->name;
  document.software = SoftwareName();
  document.measured_ms = UnixMs();
  // The measurement is kept even when no profile can be proposed from it: it shows why.
  if (!options.calibration.empty()) {
    ENAMEL_RETURN_IF_ERROR(WriteFileDurably(options.calibration, AsBytes(scene::ToJson(document))));
    std::printf("measurement: %s\n", options.calibration.c_str());
  }
  if (subject.real) ENAMEL_RETURN_IF_ERROR(KeepForAttempts(options, document, subject));
  ENAMEL_RETURN_IF_ERROR(proposed.status());
  proposed->bus_delay_ticks.source += answers;
  // A simulated device is no unit.
  proposed->delay_measured = subject.real;
  proposed->friction_measured = subject.real && scene::FrictionOf(document).has_value();
  for (const std::string& member : scene::AskedFor(*proposed)) {
    std::printf(
        "not measured, and not published: %s. Ask the maker, and write it into the profile\n",
        member.c_str());
  }
  std::printf("proposed: Kc = %.3f N/mm, K = %.3f N/mm at %d Hz\n",
              static_cast<double>(proposed->coupling_mn_per_mm.value) * 1e-3,
              static_cast<double>(proposed->max_stiffness_mn_per_mm.value) * 1e-3, options.rate_hz);
  if (options.out.empty()) {
    std::printf("nothing was written: '--out FILE' writes this as a device profile\n");
    return Status::Ok();
  }
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(options.out, AsBytes(scene::ToJson(*proposed))));
  std::printf("profile: %s. 'enamel-server admin put-profile' adds it at the server\n",
              options.out.c_str());
  return Status::Ok();
}

}  // namespace enamel::station
