#include "station/lab/app/explain.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "common/cutting/voxel_limit.h"
#include "common/import/scene_folder.h"
#include "common/program/log.h"
#include "common/program/output.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "station/lab/app/explain_steps.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;
using scene::Part;

Result<scene::Exercise> Choose(const scene::Scene& scene, const std::string& name) {
  auto all = scene::BuiltinExercises(scene, HashSha256(AsBytes(scene::ToJson(scene))));
  std::string known;
  for (const scene::Exercise& e : all) {
    if (name.empty() || e.name == name || e.name == name + "-" + scene.name) return e;
    known += (known.empty() ? "" : ", ") + e.name;
  }
  return Status(Code::kNotFound,
                "scene '" + scene.name + "' has no exercise '" + name +
                    "': " + (known.empty() ? "it has none" : "it has " + known),
                "exercise");
}

Result<Explained> Prepare(const ExplainCommand& options) {
  Explained s;
  ENAMEL_ASSIGN_OR_RETURN(auto built, LoadAt(options, options.voxel_um * 1000));
  s.built = std::move(built);
  // As a ticket would: a scene that a station refuses is not worth measuring.
  ENAMEL_RETURN_IF_ERROR(scene::CheckVolume(s.built.scene, s.built.volume));
  ENAMEL_ASSIGN_OR_RETURN(auto exercise, Choose(s.built.scene, options.exercise));
  s.exercise = std::move(exercise);
  ENAMEL_ASSIGN_OR_RETURN(auto profile, scene::FindProfile(options.profile));
  s.profile = profile;
  ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(s.built.scene, s.exercise, s.profile));
  s.params = params;
  return s;
}
// "+240 to +300", "in noise", "-".
std::string NsText(const Worth& worth) {
  if (!worth.ns_per_tick) return "-";
  if (worth.within_noise) return "in noise";
  char text[64];
  std::snprintf(text, sizeof text, "%+.0f to %+.0f", worth.ns_per_tick->low,
                worth.ns_per_tick->high);
  return text;
}

void PrintPart(const Part& part, const Worth& worth) {
  char mb[24] = "-";
  if (worth.mb) std::snprintf(mb, sizeof mb, "%+.2f", *worth.mb);
  std::printf("%-15s %-9s %18s %9s  %s; %s\n", std::string(part.name).c_str(),
              part.kept ? "kept" : "left out", NsText(worth).c_str(), mb, part.why.c_str(),
              worth.note.c_str());
}

json::value IntervalJson(const Interval& i) {
  return json::object{{"value", i.value}, {"low", i.low}, {"high", i.high}};
}

json::object PartJson(const Part& part, const Worth& worth) {
  json::object out{{"part", part.name}, {"kept", part.kept}, {"why", part.why}};
  out["ns_per_tick"] = worth.ns_per_tick && !worth.within_noise ? IntervalJson(*worth.ns_per_tick)
                                                                : json::value(nullptr);
  out["within_noise"] = worth.within_noise;
  out["mb"] = worth.mb ? json::value(*worth.mb) : json::value(nullptr);
  out["measured"] = worth.note;
  return out;
}
// Whether the voxel is fine enough for the exercise's burs: printed, and a refusal of graded work.
Status CheckVoxel(const Explained& s, json::object& out) {
  const int32_t voxel_nm = s.built.scene.voxel_nm;
  double off = 0;
  for (const cutting::Bur& bur : core::BursOf(s.params)) {
    off = std::max(off, cutting::VoxelForceError(bur, voxel_nm));
  }
  const auto coarse = scene::WhyTooCoarse(s.exercise, voxel_nm);
  out["voxel_force_error"] = off;
  out["voxel_verdict"] = !coarse ? "fine" : s.exercise.graded ? "refused" : "warned";
  if (!coarse) {
    std::printf("\nforce at this voxel: off by up to %.1f %% in a groove\n", 100 * off);
    return Status::Ok();
  }
  if (s.exercise.graded)
    return Status(Code::kInvalidInput, "exercise '" + s.exercise.name + "' is graded: " + *coarse,
                  "voxel_um");
  program::SayWarning(*coarse);
  return Status::Ok();
}

}  // namespace

void ShowProgress(const std::string& what) {
  if (program::LogIsJson()) return;
  bool terminal = ::isatty(STDERR_FILENO) != 0;
  std::fprintf(stderr, terminal ? "\r\033[Kmeasuring: %s" : "measuring: %s\n", what.c_str());
}
void EndProgress() {
  if (::isatty(STDERR_FILENO) != 0 && !program::LogIsJson()) std::fprintf(stderr, "\r\033[K");
}
Result<scene::BuiltScene> LoadAt(const ExplainCommand& options, int32_t voxel_nm) {
  return import::LoadScene(options.scene, voxel_nm,
                           static_cast<size_t>(options.memory_mb) * 1'000'000);
}
Status ExplainScene(const ExplainCommand& options) {
  ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(options.json, "--json"));
  ENAMEL_ASSIGN_OR_RETURN(auto subject, Prepare(options));
  const Appraisal found = Appraise(
      subject,
      scene::ListParts(subject.built.scene, subject.exercise,
                       {options.window, options.replay, subject.params.peak_torque_un_m > 0}));
  const StepCost& base = found.base;
  std::printf("scene '%s', voxels of %.0f um; exercise '%s'; %s at %d Hz\n",
              subject.built.scene.name.c_str(), subject.built.scene.voxel_nm * 1e-3,
              subject.exercise.name.c_str(), subject.profile.name.c_str(),
              subject.exercise.rate_hz);
  std::printf(
      "as planned: tick %.2f us mean, %.2f us p99; volume %.1f MB. Per tick the least of %d runs\n"
      "over %zu ticks, bur engaged in %.0f %%.\n"
      "ns a tick and MB: the cost of a kept part, or of a left out part if it were kept. Runs "
      "with\n"
      "and without take turns, %d each; 96 %% interval of the median. In noise: it meets the "
      "plan's\n"
      "own difference from itself, %+.0f to %+.0f ns.\n\n",
      base.mean_us, base.p99_us, found.volume_mb, kReplays, kTicks, 100 * base.engaged_share,
      kRounds, found.noise_ns.low, found.noise_ns.high);
  std::printf("part            plan                 ns/tick        MB  why; how measured\n");
  json::array parts;
  for (const auto& [part, worth] : found.rows) {
    PrintPart(part, worth);
    parts.push_back(PartJson(part, worth));
  }
  json::object out{{"scene", subject.built.scene.name},
                   {"exercise", subject.exercise.name},
                   {"profile", subject.profile.name},
                   {"voxel_nm", subject.built.scene.voxel_nm},
                   {"mean_us", base.mean_us},
                   {"p99_us", base.p99_us},
                   {"noise_ns", IntervalJson(found.noise_ns)},
                   {"volume_mb", found.volume_mb},
                   {"engaged_share", base.engaged_share},
                   {"parts", std::move(parts)}};
  Status fine = CheckVoxel(subject, out);
  Status decided;
  if (options.budget_us) decided = DecideBudget(options, subject, base, out);
  // Before the verdict: the figures matter most if nothing fits.
  ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(options.json, out));
  return decided.ok() ? fine : decided;
}

}  // namespace enamel::station::lab
