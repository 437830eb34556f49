#include "station/lab/suites/exercise_strokes.h"

#include <algorithm>
#include <cmath>

#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "station/lab/grades/operator_run.h"
#include "station/lab/laws/motions.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

constexpr int32_t kVoxel_nm = 100'000;
constexpr uint64_t kMaxTicks = 600'000;

Result<std::vector<ExerciseStroke>> StrokesOn(const std::string& scene,
                                              const StrokesOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(const auto built, scene::BuildBuiltinScene(scene, kVoxel_nm));
  ENAMEL_ASSIGN_OR_RETURN(const auto profile, scene::FindProfile("pointer"));
  std::vector<ExerciseStroke> out;
  for (const scene::Exercise& exercise :
       scene::BuiltinExercises(built.scene, HashSha256(AsBytes(scene::ToJson(built.scene))))) {
    for (const std::string& person : options.people) {
      std::optional<fidelity::CutStrokes> strokes;
      const auto done = RunOperator(*FindOperator(person), built, exercise, profile, 0, kMaxTicks,
                                    [&](const auto& params, const trace::Tick& tick) {
                                      if (!strokes) strokes.emplace(params);
                                      strokes->Add(tick.input, tick.witness);
                                    });
      // Not every exercise can be planned on every tooth.
      if (!done.ok() || !strokes) continue;
      int number = 0;
      for (fidelity::CutStroke& stroke : strokes->Spread(options.each))
        out.push_back({std::move(stroke), exercise.name, person + "-" + std::to_string(++number)});
    }
  }
  return out;
}

}  // namespace

Result<std::vector<ExerciseStroke>> StrokesOfExercises(const StrokesOptions& options) {
  const auto scenes = options.scenes.empty() ? scene::BuiltinSceneNames() : options.scenes;
  std::vector<Result<std::vector<ExerciseStroke>>> found(
      scenes.size(), Result<std::vector<ExerciseStroke>>(std::vector<ExerciseStroke>()));
  ParallelFor(scenes.size(), options.threads,
              [&](size_t i) { found[i] = StrokesOn(scenes[i], options); });
  std::vector<ExerciseStroke> out;
  for (auto& some : found) {
    ENAMEL_RETURN_IF_ERROR(some.status());
    out.insert(out.end(), some->begin(), some->end());
  }
  return out;
}

}  // namespace enamel::station::lab
