#include "station/lab/app/qualify.h"

#include <algorithm>
#include <chrono>
#include <fstream>

#include "common/base/in_document.h"
#include "common/base/mutex.h"
#include "common/program/output.h"
#include "common/scene/find_profile.h"
#include "common/scene/profile_criteria.h"
#include "station/lab/laws/motions.h"
#include "station/lab/report/draw.h"
#include "station/lab/report/report.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

struct Suite {
  const char* name;
  void (*run)(SuiteContext&);
};
constexpr Suite kSuites[] = {{"paper", &RunPaperSuite},
                             {"hand", &RunHandSuite},
                             {"map", &RunMapSuite},
                             {"strokes", &RunStrokesSuite},
                             {"pecks", &RunPecksSuite},
                             {"withdrawal", &RunWithdrawalSuite},
                             {"calibration", &RunCalibrationSuite},
                             {"watch", &RunWatchSuite},
                             {"laws", &RunLawsSuite},
                             {"front", &RunFrontSuite},
                             {"estimators", &RunEstimatorsSuite},
                             {"extreme", &RunExtremeSuite},
                             {"adversary", &RunAdversarySuite},
                             {"random", &RunRandomSuite},
                             {"cutting", &RunCuttingSuite}};

// The suites measure the three axes of force. A torque that is not passive would shake the hand.
Status CheckTorque(const scene::DeviceProfile& profile) {
  for (const scene::ProfileCriterion& c : scene::CheckProfile(profile)) {
    // The suites measure the other criteria, even if a profile fails them.
    if (c.met || !c.member.starts_with("torque/")) continue;
    char found[80];
    std::snprintf(found, sizeof found, "expected %s %.4g %s, found %.4g",
                  c.at_least ? "at least" : "at most", c.limit, c.unit.c_str(), c.value);
    return {Code::kInvalidInput, c.member + ": " + c.title + " (" + c.formula + "): " + found,
            c.member};
  }
  return Status::Ok();
}

// A custom document, by its path.
Result<std::vector<DeviceModel>> ModelIn(const std::string& path) {
  ENAMEL_ASSIGN_OR_RETURN(scene::DeviceProfile profile, scene::FindProfile(path));
  Result<DeviceModel> model = ModelOf(profile);
  Status status = model.status();
  if (status.ok()) status = CheckTorque(profile);
  if (status.ok()) return std::vector<DeviceModel>{*model};
  return InDocument(path, status);
}

Result<std::vector<DeviceModel>> ModelsFor(const std::string& name) {
  // A path, not a name: names of profiles have no dot.
  if (name.ends_with(".json")) return ModelIn(name);
  std::vector<DeviceModel> out;
  std::string known;
  for (const scene::DeviceProfile& p : ShippedProfiles()) {
    known += (known.empty() ? "" : ", ") + p.name;
    // Listed before it is left out, so that a refusal can name all.
    if (name != "all" && name != p.name) continue;
    Result<DeviceModel> model = ModelOf(p);
    if (!model.ok())
      return Status(model.status().code(), p.name + ": " + model.status().message(),
                    model.status().field());
    out.push_back(*model);
  }
  if (out.empty())
    return Status(Code::kInvalidInput,
                  "unknown profile '" + name + "': expected all, one of " + known +
                      ", or the path of a profile document (….json)",
                  "profile");
  return out;
}

Status CheckSuites(const std::vector<std::string>& names) {
  const std::vector<std::string> known = SuiteNames();
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string all;
    for (const std::string& each : known) all += (all.empty() ? "" : ", ") + each;
    return {Code::kInvalidInput, "unknown suite '" + name + "': expected one of " + all, "suite"};
  }
  return Status::Ok();
}

// Other motions give other figures, so what is named must exist.
Status CheckRecordings(const QualifyOptions& options) {
  if (options.motion.empty()) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(std::vector<HandMotion> found, RecordedMotions(options.motion));
  if (!found.empty()) return Status::Ok();
  return {Code::kInvalidInput,
          "--motion: expected a CSV file of a motion or a folder of them, found none in " +
              options.motion + "; leave the option out for generated motions",
          "motion"};
}

// Nothing would be said of a calibration that belongs to another device.
Status CheckCalibration(const QualifyOptions& options, const std::vector<DeviceModel>& models) {
  if (options.calibration.empty()) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(scene::Calibration found, CalibrationIn(options.calibration));
  for (const DeviceModel& m : models) {
    if (m.name == found.profile) return Status::Ok();
  }
  return {Code::kInvalidInput,
          "--calibration: it is of profile '" + found.profile + "'; choose that with --profile",
          "calibration"};
}

// One line, rewritten at most ten times a second.
Progress ProgressTo(std::FILE* out) {
  if (out == nullptr) return [](const char*, size_t, size_t) {};
  struct Shown {
    Mutex guard;
    std::chrono::steady_clock::time_point last ENAMEL_GUARDED_BY(guard){};
  };
  auto shown = std::make_shared<Shown>();
  return [out, shown](const char* what, size_t done, size_t all) {
    // Suites report from several threads; lines must not run into each other.
    MutexLock lock(shown->guard);
    auto now = std::chrono::steady_clock::now();
    if (done < all && now - shown->last < std::chrono::milliseconds(100)) return;
    shown->last = now;
    std::fprintf(out, "\r%-60.60s %5zu / %zu", what, done, all);
    if (done == all) std::fprintf(out, "\r%80s\r", "");
    std::fflush(out);
  };
}

void Print(std::FILE* out, const Findings& f) {
  for (const Table& t : f.tables) std::fputs(TextOf(t).c_str(), out);
  for (const RandomSummary& r : f.random) {
    std::fprintf(
        out,
        "Random cases, %s: %d of %d hold both bounds in four hands (%.1f %%); ripple %d, felt "
        "error %d; seed %llu\n",
        r.title.c_str(), r.held, r.cases, 100.0 * r.held / std::max(1, r.cases), r.ripple, r.error,
        static_cast<unsigned long long>(f.seed));
  }
  for (const VerdictMap& m : f.maps) {
    size_t counts[4] = {};
    for (Verdict v : m.cells) ++counts[static_cast<size_t>(v)];
    std::fprintf(out, "%s: %zu passive, %zu stable with these grips, %zu bounded, %zu unstable\n",
                 m.title.c_str(), counts[0], counts[1], counts[2], counts[3]);
  }
  size_t rows = f.rows.size() + f.cutting.size() + f.hands.size() + f.feel.size() +
                f.budgets.size() + f.seconds_felt.size() + f.extremes.size() +
                f.exercise_strokes.size() + f.pecks.size() + f.watch.size();
  for (const JointFront& front : f.fronts) rows += front.points.size();
  if (!f.strokes.empty()) std::fprintf(out, "%zu devices' strokes, ", f.strokes.size());
  std::fprintf(out, "%zu rows in %.1f s\n", rows, f.seconds);
}

}  // namespace

std::vector<std::string> SuiteNames() {
  std::vector<std::string> out;
  for (const Suite& suite : kSuites) out.emplace_back(suite.name);
  out.emplace_back("all");
  return out;
}

int RunQualify(const QualifyOptions& options) {
  auto Fail = [&](const Status& status) {
    if (options.errors) options.errors(status.message());
    return 1;
  };
  // Checks for every possible error before the first suite: a full run is long.
  if (Status status = CheckSuites(options.suites); !status.ok()) return Fail(status);
  if (options.cases < 1 || options.cases > 1'000'000)
    return Fail({Code::kInvalidInput, "--cases: expected 1 to 1000000", "cases"});
  if (Status status = CheckRecordings(options); !status.ok()) return Fail(status);
  if (Status status = program::CheckOutputFile(options.json_path, "--json"); !status.ok())
    return Fail(status);
  if (!options.report.empty()) {
    if (Status status = CheckReport(options.report, "--report"); !status.ok()) return Fail(status);
  }
  Result<std::vector<DeviceModel>> models = ModelsFor(options.profile);
  if (!models.ok()) return Fail(models.status());
  if (Status status = CheckCalibration(options, *models); !status.ok()) return Fail(status);
  auto from = std::chrono::steady_clock::now();
  Findings findings;
  findings.models = *models;
  findings.seed = options.seed;
  findings.quick = options.quick;
  SuiteContext context{options, findings, ProgressTo(options.progress)};
  auto Wanted = [&](const char* name) {
    return std::any_of(options.suites.begin(), options.suites.end(),
                       [&](const std::string& s) { return s == "all" || s == name; });
  };
  for (const Suite& suite : kSuites) {
    if (Wanted(suite.name)) suite.run(context);
  }
  findings.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
  if (options.out != nullptr) Print(options.out, findings);
  if (!options.json_path.empty()) {
    std::ofstream json(options.json_path, std::ios::binary);
    json << JsonOf(findings);
    json.close();
    if (!json)
      return Fail(
          {Code::kStorage,
           "cannot write " + options.json_path + ": choose a path that can be written with --json",
           "json"});
  }
  if (!options.report.empty()) {
    Status status = WriteReport(JsonOf(findings), options.report);
    if (!status.ok()) return Fail(status);
  }
  // A separate code: a failed proof differs from a path that cannot be written.
  bool broken = std::any_of(findings.attacks.begin(), findings.attacks.end(),
                            [](const Attack& a) { return a.proved && a.violations > 0; });
  return broken ? 2 : 0;
}

}  // namespace enamel::station::lab
