#include "station/lab/grades/hand_signs.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scoring/movement/hand_figures.h"
#include "common/scoring/movement/motion.h"
#include "common/scoring/movement/smoothness.h"
#include "station/devices/operators.h"
#include "station/lab/grades/operator_run.h"
#include "station/lab/laws/motions.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;

constexpr size_t kStep = 10;  // ms: people's jerk and directions, not the encoder's steps
constexpr double kRate_hz = 1000, kSteps_hz = kRate_hz / kStep;
constexpr double kMinWay_m = 0.5e-3;
constexpr double kPauseShare = 0.1;
constexpr uint64_t kOtherSeed = 101;
constexpr int kVoxel_nm = 200'000;  // the tooth is only there to be cut

struct Sign {
  const char* name;
  double HandSigns::*value;
  std::optional<double> threshold{};
};
constexpr Sign kSigns[] = {
    {"tremor, 8 to 12 Hz (um)", &HandSigns::tremor_um, scoring::kMinTremor_um},
    {"log dimensionless jerk", &HandSigns::jerk},
    {"spectral arc length", &HandSigns::arc_length},
    {"entropy of directions (bit)", &HandSigns::direction_bits},
    {"pauses (%)", &HandSigns::pause_percent}};

// One of 26 directions: each axis forward, back or neither (less than half of the longest).
size_t DirectionOf(const dvec3& step) {
  const double most = std::max({std::fabs(step.x), std::fabs(step.y), std::fabs(step.z)});
  auto side = [&](double v) -> size_t { return std::fabs(v) < 0.5 * most ? 0 : v > 0 ? 1 : 2; };
  return side(step.x) * 9 + side(step.y) * 3 + side(step.z);
}

double EntropyBits(const std::vector<dvec3>& steps) {
  std::array<double, 27> counts{};
  for (const dvec3& step : steps) counts[DirectionOf(step)] += 1;
  double bits = 0;
  for (double count : counts) {
    const double share = count / static_cast<double>(steps.size());
    if (share > 0) bits -= share * std::log2(share);
  }
  return bits;
}

// Seconds in which a hand moved.
std::vector<HandSigns> AllSigns(const std::vector<dvec3>& way_m) {
  std::vector<HandSigns> out;
  HandSigns signs;
  for (size_t at = 0; at + kSecond <= way_m.size(); at += kSecond) {
    if (SignsOf(&way_m[at], signs)) out.push_back(signs);
  }
  return out;
}

using Way = std::vector<dvec3>;

// Distance of two motions relative to the first one's size.
double NearnessOf(const Way& a, const Way& b) {
  const scoring::Motion other[] = {scoring::MotionAlong(b)};
  const auto near = scoring::NearnessTo(scoring::MotionAlong(a), other);
  return near->nearest_m / near->size_m;
}

// Fifths of the path, by length: people who repeat a path take another time for each.
constexpr size_t kParts = 5;
std::vector<Way> PartsOf(const Way& way) {
  std::vector<double> gone = {0};
  for (size_t i = 1; i < way.size(); ++i) {
    const dvec3 step = way[i] - way[i - 1];
    gone.push_back(gone.back() + std::sqrt(Dot(step, step)));
  }
  std::vector<Way> out(kParts);
  for (size_t i = 0; i < way.size(); ++i) {
    const double part = kParts * gone[i] / gone.back();
    out[std::min(kParts - 1, static_cast<size_t>(part))].push_back(way[i]);
  }
  return out;
}

// As somebody might pass off a recorded motion.
std::vector<Way> CopiesOf(const Way& way, uint64_t seed) {
  constexpr double kNoiseOfSize = 0.01, kLater = 0.05;
  std::mt19937_64 random(seed);
  dvec3 lo = way[0], hi = way[0];
  for (const dvec3& p : way) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const double noise_m = kNoiseOfSize * std::sqrt(Dot(hi - lo, hi - lo));
  Way noisy,
      later(way.begin() + static_cast<ptrdiff_t>(kLater * static_cast<double>(way.size())),
            way.end()),
      slower;
  auto any = [&] { return 2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1; };
  for (const dvec3& p : way) noisy.push_back(p + dvec3(any(), any(), any()) * noise_m);
  for (size_t i = 0; i < way.size(); ++i) {
    // More and more so.
    for (size_t k = 0; k < 1 + 2 * i / way.size(); ++k) slower.push_back(way[i]);
  }
  return {noisy, later, slower};
}

// `again`: people who repeated the motion.
SignRoc NearnessOfCopies(const std::vector<HandMotion>& motions, std::vector<double>& again) {
  std::vector<std::vector<Way>> parts;
  for (const HandMotion& motion : motions) parts.push_back(PartsOf(motion.way_m));
  std::vector<double> copied;
  for (size_t i = 0; i < parts.size(); ++i) {
    for (size_t k = 0; k < kParts; ++k) {
      const Way& part = parts[i][k];
      for (size_t j = 0; j < i; ++j) again.push_back(NearnessOf(part, parts[j][k]));
      for (const Way& copy : CopiesOf(part, 1 + i * kParts + k)) {
        copied.push_back(NearnessOf(copy, part));
      }
    }
  }
  return RocOf("nearness of a copy (of size)", again, std::move(copied), scoring::kNearOfSize);
}

// The device's own tip positions, once a tick of 1 kHz.
Result<Way> WayOf(const OperatorPreset& preset, const scene::BuiltScene& built,
                  const scene::Exercise& exercise, const scene::DeviceProfile& profile,
                  size_t ticks, uint64_t seed = 0) {
  std::vector<dvec3> out;
  auto see = [&](const core::CoreParams& params, const trace::Tick& tick) {
    dvec3 at;
    for (size_t axis = 0; axis < 3; ++axis) {
      at[static_cast<int>(axis)] = 1e-9 * tick.input.counts[axis] * params.resolution_nm[axis];
    }
    out.push_back(at);
  };
  ENAMEL_RETURN_IF_ERROR(RunOperator(preset, built, exercise, profile, seed, ticks, see).status());
  return out;
}

// Share of `programs` outside the limit that `share` of `people` exceed, above or below.
double FoundAt(double share, const std::vector<double>& people,
               const std::vector<double>& programs) {
  // Sorted. So many people may be taken for programs.
  const auto wrong = static_cast<size_t>(share * static_cast<double>(people.size()));
  const double above = people[people.size() - 1 - wrong], below = people[wrong];
  size_t higher = 0, lower = 0;
  for (double value : programs) {
    higher += value > above ? 1 : 0;
    lower += value < below ? 1 : 0;
  }
  return static_cast<double>(std::max(higher, lower)) / static_cast<double>(programs.size());
}

// Of values in order.
double ShareBelow(double threshold, const std::vector<double>& values) {
  const auto end = std::lower_bound(values.begin(), values.end(), threshold);
  return static_cast<double>(end - values.begin()) / static_cast<double>(values.size());
}

}  // namespace

bool SignsOf(const dvec3* position_m, HandSigns& out) {
  std::vector<dvec3> means;
  for (size_t at = 0; at < kSecond; at += kStep) {
    dvec3 sum(0);
    for (size_t i = 0; i < kStep; ++i) sum += position_m[at + i];
    means.push_back(sum / static_cast<double>(kStep));
  }
  std::vector<dvec3> steps;
  std::vector<double> speed_m_s;
  double way_m = 0, fastest = 0;
  for (size_t i = 1; i < means.size(); ++i) {
    const dvec3 step = means[i] - means[i - 1];
    const double length = std::sqrt(Dot(step, step));
    steps.push_back(step);
    speed_m_s.push_back(length * kSteps_hz);
    fastest = std::max(fastest, speed_m_s.back());
    way_m += length;
  }
  if (way_m < kMinWay_m) return false;
  scoring::TremorMeter tremor(static_cast<uint32_t>(kRate_hz));
  for (size_t i = 0; i < kSecond; ++i) tremor.Add(position_m[i], true);
  const std::optional<double> rms = tremor.Rms_m(), jerk = scoring::LogDimensionlessJerk(speed_m_s),
                              arc = scoring::SpectralArcLength(speed_m_s, kSteps_hz);
  if (!rms || !jerk || !arc) return false;
  const auto pauses = std::count_if(speed_m_s.begin(), speed_m_s.end(),
                                    [&](double v) { return v < kPauseShare * fastest; });
  out = {*rms * 1e6, *jerk, *arc, EntropyBits(steps),
         100 * static_cast<double>(pauses) / static_cast<double>(speed_m_s.size())};
  return true;
}

SignRoc RocOf(std::string sign, std::vector<double> people, std::vector<double> programs,
              std::optional<double> threshold) {
  std::sort(people.begin(), people.end());
  std::sort(programs.begin(), programs.end());
  SignRoc out;
  out.sign = std::move(sign);
  out.people = people.size();
  out.programs = programs.size();
  // Mann and Whitney's count: pairs in which the program's is higher, ties half.
  double higher = 0;
  for (double value : programs) {
    const auto [first, last] = std::equal_range(people.begin(), people.end(), value);
    higher += static_cast<double>(first - people.begin()) + 0.5 * static_cast<double>(last - first);
  }
  const double n = static_cast<double>(people.size()), m = static_cast<double>(programs.size());
  const double a = higher / (n * m);
  const double q1 = a / (2 - a), q2 = 2 * a * a / (1 + a);
  out.area = a;
  out.standard_error = std::sqrt(
      std::max(0.0, a * (1 - a) + (m - 1) * (q1 - a * a) + (n - 1) * (q2 - a * a)) / (n * m));
  out.found_at_5 = FoundAt(0.05, people, programs);
  out.found_at_10 = FoundAt(0.1, people, programs);
  out.found_at_20 = FoundAt(0.2, people, programs);
  out.threshold = threshold;
  if (threshold) {
    out.mistaken = ShareBelow(*threshold, people);
    out.found = ShareBelow(*threshold, programs);
  }
  return out;
}

Result<std::vector<SignRoc>> MeasureHandSigns(
    const HandSignsOptions& options,
    const std::function<void(const std::string&, double)>& progress) {
  ENAMEL_ASSIGN_OR_RETURN(const auto motions, RecordedMotions(options.people));
  std::vector<HandSigns> people, programs;
  std::vector<double> program_pairs;
  for (const HandMotion& motion : motions) {
    const auto signs = AllSigns(motion.way_m);
    people.insert(people.end(), signs.begin(), signs.end());
  }
  if (people.empty()) {
    return Status(Code::kNotFound,
                  "no recording of a moving hand in '" + options.people +
                      "': expected .csv files with t_s, px_m, py_m, pz_m at 1 kHz",
                  "people");
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto built, scene::BuildBuiltinScene("block", kVoxel_nm));
  const auto exercises =
      scene::BuiltinExercises(built.scene, HashSha256(AsBytes(scene::ToJson(built.scene))));
  const auto exercise = std::ranges::find(exercises, options.exercise, &scene::Exercise::name);
  if (exercise == exercises.end()) {
    return Status(Code::kNotFound, "the block has no exercise '" + options.exercise + "'",
                  "exercise");
  }
  const scene::DeviceProfile profile = scene::BuiltinProfiles().front();
  for (size_t i = 0; i < options.operators.size(); ++i) {
    const std::string& name = options.operators[i];
    if (progress) {
      progress(name, static_cast<double>(i) / static_cast<double>(options.operators.size()));
    }
    const OperatorPreset* preset = FindOperator(name);
    if (preset == nullptr) {
      return Status(Code::kNotFound, "no simulated person is called '" + name + "'", "operator");
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto way,
                            WayOf(*preset, built, *exercise, profile, options.seconds * kSecond));
    const auto signs = AllSigns(way);
    programs.insert(programs.end(), signs.begin(), signs.end());
    ENAMEL_ASSIGN_OR_RETURN(const auto again, WayOf(*preset, built, *exercise, profile,
                                                    options.seconds * kSecond, kOtherSeed));
    const auto parts = PartsOf(way), others = PartsOf(again);
    for (size_t k = 0; k < kParts; ++k) program_pairs.push_back(NearnessOf(parts[k], others[k]));
  }
  if (programs.empty()) {
    return Status(Code::kNotFound, "no simulated person moved for a second", "operator");
  }
  std::vector<SignRoc> out;
  for (const Sign& sign : kSigns) {
    std::vector<double> of_people, of_programs;
    for (const HandSigns& signs : people) of_people.push_back(signs.*sign.value);
    for (const HandSigns& signs : programs) of_programs.push_back(signs.*sign.value);
    out.push_back(RocOf(sign.name, std::move(of_people), std::move(of_programs), sign.threshold));
  }
  // A single recording has no repetition.
  if (motions.size() > 1) {
    std::vector<double> again;
    out.push_back(NearnessOfCopies(motions, again));
    out.push_back(
        RocOf("nearness, same program (of size)", again, program_pairs, scoring::kNearOfSize));
  }
  return out;
}

json::object HandSignsJson(const std::vector<SignRoc>& rows) {
  json::array out;
  for (const SignRoc& r : rows) {
    out.push_back(
        json::object{{"figure", r.sign},
                     {"people", r.people},
                     {"programs", r.programs},
                     {"area", r.area},
                     {"standard_error", r.standard_error},
                     {"found_at_5_percent", r.found_at_5},
                     {"found_at_10_percent", r.found_at_10},
                     {"found_at_20_percent", r.found_at_20},
                     {"threshold", r.threshold ? json::value(*r.threshold) : json::value()},
                     {"mistaken_at_threshold", r.mistaken},
                     {"found_at_threshold", r.found}});
  }
  return {{"format", 1}, {"rows", std::move(out)}};
}

}  // namespace enamel::station::lab
