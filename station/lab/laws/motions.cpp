#include "station/lab/laws/motions.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "common/base/file.h"
#include "common/fidelity/tracks.h"

namespace enamel::station::lab {
namespace {

using fidelity::MinimumJerk;

constexpr size_t kMaxFiles = 64, kLargestFile = 4 << 20;

const dvec3 kOblique = glm::normalize(dvec3(1, 2, 3));

size_t Steps(double duration_s) { return static_cast<size_t>(duration_s / kWayStep_s + 0.5); }

dvec3 Across(const dvec3& direction) {
  dvec3 other = std::fabs(direction.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  return glm::normalize(glm::cross(direction, other));
}

// The first `n` numbers of a line of comma-separated numbers.
bool Numbers(std::string_view line, double* out, int n) {
  const char* at = line.data();
  const char* end = at + line.size();
  for (int i = 0; i < n; ++i) {
    auto [next, error] = std::from_chars(at, end, out[i]);
    if (error != std::errc() || !std::isfinite(out[i])) return false;
    if (i + 1 < n && (next == end || *next != ',')) return false;
    at = next + 1;
  }
  return true;
}

Result<HandMotion> Recorded(const std::filesystem::path& path) {
  ENAMEL_ASSIGN_OR_RETURN(Bytes bytes, ReadFile(path, kLargestFile));
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  auto Refuse = [&](size_t line, const char* what) {
    return Status(Code::kInvalidInput,
                  path.string() + ":" + std::to_string(line) + ": " + what +
                      "; expected columns t_s,px_m,py_m,pz_m at 1 kHz",
                  "motion");
  };
  HandMotion motion;
  motion.name = "human-" + path.stem().string();
  motion.human = true;
  for (size_t line = 1; !text.empty(); ++line) {
    size_t end = text.find('\n');
    std::string_view row = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    if (line == 1) {
      if (!row.starts_with("t_s,px_m,py_m,pz_m")) return Refuse(line, "found other columns");
      continue;
    }
    if (row.empty() || row == "\r") continue;
    double v[4];
    if (!Numbers(row, v, 4)) return Refuse(line, "found no four numbers");
    // Recordings with gaps are refused: a jump would be a false speed.
    if (std::fabs(v[0] - static_cast<double>(motion.way_m.size()) * kWayStep_s) > 0.5 * kWayStep_s)
      return Refuse(line, "found another time than a millisecond after the last");
    motion.way_m.push_back({v[1], v[2], v[3]});
  }
  if (motion.way_m.size() < 100) return Refuse(1, "found fewer than 100 rows");
  motion.way_m = fidelity::Smoothed(motion.way_m);
  return motion;
}

}  // namespace

double MeanSpeed(const HandMotion& m) {
  double length = 0;
  for (size_t i = 1; i < m.way_m.size(); ++i) length += glm::length(m.way_m[i] - m.way_m[i - 1]);
  return length / (static_cast<double>(m.way_m.size() - 1) * kWayStep_s);
}

HandMotion ScaledToSpeed(HandMotion motion, double mean) {
  double scale = mean / MeanSpeed(motion);
  dvec3 from = motion.way_m.front();
  for (dvec3& x : motion.way_m) x = (x - from) * scale;
  return motion;
}

HandMotion ReversalMotion(double speed, double out_s, double back_s, const dvec3& direction) {
  HandMotion m{"reversal", {}, out_s, false};
  for (size_t i = 0; i <= Steps(out_s + back_s); ++i) {
    double t = static_cast<double>(i) * kWayStep_s;
    m.way_m.push_back(direction * (speed * (t < out_s ? t : 2 * out_s - t)));
  }
  return m;
}

HandMotion StrokesMotion(double mean, double stroke_s, int strokes, const dvec3& direction) {
  HandMotion m{"strokes", {}, -1, false};
  double length = mean * stroke_s;
  for (size_t i = 0; i <= Steps(stroke_s * strokes); ++i) {
    double u = static_cast<double>(i) * kWayStep_s / stroke_s;
    double whole = std::floor(u), s = MinimumJerk(u - whole);
    bool back = static_cast<int64_t>(whole) % 2 != 0;
    m.way_m.push_back(direction * (length * (back ? 1 - s : s)));
  }
  return m;
}

HandMotion CircleMotion(double speed, double radius) {
  HandMotion m{"circle", {}, -1, false};
  dvec3 a = Across(kOblique), b = glm::cross(kOblique, a);
  double turn = 2 * M_PI * 2.5;
  for (size_t i = 0; i <= Steps(turn * radius / speed); ++i) {
    double phi = static_cast<double>(i) * kWayStep_s * speed / radius;
    m.way_m.push_back((a * std::sin(phi) + b * (1 - std::cos(phi))) * radius);
  }
  return m;
}

HandMotion CornerMotion(double speed, double leg_s) {
  HandMotion m{"corner", {}, -1, false};
  dvec3 across = Across(kOblique);
  for (size_t i = 0; i <= Steps(2 * leg_s); ++i) {
    double t = static_cast<double>(i) * kWayStep_s;
    m.way_m.push_back(kOblique * (speed * std::min(t, leg_s)) +
                      across * (speed * std::max(0.0, t - leg_s)));
  }
  return m;
}

HandMotion TremorMotion(double speed, double amplitude, double duration_s, uint64_t seed) {
  HandMotion m{"tremor", {}, -1, false};
  Random r(seed);
  double hz[3], phase[3];
  for (int i = 0; i < 3; ++i) hz[i] = r.Between(8, 12), phase[i] = r.Between(0, 2 * M_PI);
  for (size_t i = 0; i <= Steps(duration_s); ++i) {
    double t = static_cast<double>(i) * kWayStep_s;
    dvec3 shake;
    for (int k = 0; k < 3; ++k) shake[k] = std::sin(2 * M_PI * hz[k] * t + phase[k]);
    m.way_m.push_back(kOblique * (speed * t) + shake * (amplitude / std::sqrt(3.0)));
  }
  return m;
}

HandMotion WanderingMotion(double mean, double duration_s, uint64_t seed) {
  HandMotion m{"wandering", {}, -1, false};
  Random r(seed);
  dvec3 at(0), home(0), tremor_phase(r.Uniform(), r.Uniform(), r.Uniform());
  double now = 0, stroke_s = 0, pause_s = 0;
  dvec3 step(0);
  double began = 0;
  for (size_t i = 0; i <= Steps(duration_s); ++i, now += kWayStep_s) {
    if (now >= began + stroke_s + pause_s) {
      at += step;
      began = now;
      stroke_s = r.LogBetween(0.3, 2);
      pause_s = r.Below(3) == 0 ? r.Between(0.05, 0.5) : 0;
      // Half of the strokes return roughly to their start.
      dvec3 way = r.Direction();
      if (r.Below(2)) way = glm::normalize(home - at + way * 1e-4);
      step = way * (stroke_s * r.LogBetween(0.3, 2));
    }
    dvec3 shake;
    for (int k = 0; k < 3; ++k) shake[k] = std::sin(2 * M_PI * ((9 + k) * now + tremor_phase[k]));
    m.way_m.push_back(at + step * MinimumJerk((now - began) / stroke_s) + shake * 2e-3);
  }
  return ScaledToSpeed(std::move(m), mean);
}

Result<std::vector<HandMotion>> RecordedMotions(const std::string& folder) {
  namespace fs = std::filesystem;
  std::vector<fs::path> paths;
  std::error_code error;
  if (fs::is_regular_file(folder, error)) paths.push_back(folder);
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (it->path().extension() == ".csv") paths.push_back(it->path());
    if (paths.size() > kMaxFiles)
      return Status(Code::kInvalidInput,
                    folder + ": expected at most " + std::to_string(kMaxFiles) + " recordings",
                    "motion");
  }
  // Folders have no order, and suites must print the same rows on every machine.
  std::sort(paths.begin(), paths.end());
  std::vector<HandMotion> out;
  for (const fs::path& path : paths) {
    ENAMEL_ASSIGN_OR_RETURN(HandMotion motion, Recorded(path));
    out.push_back(std::move(motion));
  }
  return out;
}

}  // namespace enamel::station::lab
