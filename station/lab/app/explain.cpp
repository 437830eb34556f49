#include "station/lab/app/explain.h"

#include <unistd.h>

#include <cstdio>

#include "common/base/file.h"
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
void PrintPart(const Part& part, const Worth& worth) {
  char ns[24] = "-", mb[24] = "-";
  if (worth.ns_per_tick) std::snprintf(ns, sizeof ns, "%+.0f", *worth.ns_per_tick);
  if (worth.mb) std::snprintf(mb, sizeof mb, "%+.2f", *worth.mb);
  std::printf("%-15s %-9s %9s %9s  %s; %s\n", std::string(part.name).c_str(),
              part.kept ? "kept" : "left out", ns, mb, part.why.c_str(), worth.note.c_str());
}

json::object PartJson(const Part& part, const Worth& worth) {
  json::object out{{"part", part.name}, {"kept", part.kept}, {"why", part.why}};
  out["ns_per_tick"] = worth.ns_per_tick ? json::value(*worth.ns_per_tick) : json::value(nullptr);
  out["mb"] = worth.mb ? json::value(*worth.mb) : json::value(nullptr);
  out["measured"] = worth.note;
  return out;
}
Status WriteJson(const std::filesystem::path& file, const json::object& object) {
  if (file.empty()) return Status::Ok();
  return WriteFileDurably(file, AsBytes(json::serialize(object) + "\n"));
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
      "over %zu ticks, bur engaged in %.0f %%; the same measured twice differs by %.0f ns.\n"
      "ns a tick and MB: the cost of a kept part, or of a left out part if it were kept.\n\n",
      base.mean_us, base.p99_us, found.volume_mb, kReplays, kTicks, 100 * base.engaged_share,
      found.noise_ns);
  std::printf("part            plan        ns/tick        MB  why; how measured\n");
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
                   {"noise_ns", found.noise_ns},
                   {"volume_mb", found.volume_mb},
                   {"engaged_share", base.engaged_share},
                   {"parts", std::move(parts)}};
  Status decided;
  if (options.budget_us) decided = DecideBudget(options, subject, base, out);
  // Before the verdict: the figures matter most if nothing fits.
  ENAMEL_RETURN_IF_ERROR(WriteJson(options.json, out));
  return decided;
}

}  // namespace enamel::station::lab
