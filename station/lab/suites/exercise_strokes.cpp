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
constexpr uint64_t kMostTicks = 600'000;
// Looked at in blocks, as a witness says where the bur is to 0.1 um: a slow bur moves less in a tick.
constexpr size_t kBlock = 10;
// Slower, or with less force, nobody cuts: a bur that rests in its cut.
constexpr double kLeastSpeed_m_per_s = 0.02e-3, kLeastForce_n = 0.02;
constexpr size_t kMostRest = 10, kShortest = 30, kLongest = 400;  // blocks

struct Block {
  dvec3 moved_m{0}, resisted_n{0};
  bool removes() const {
    return Dot(resisted_n, moved_m) > 0 &&
           glm::length(moved_m) > kLeastSpeed_m_per_s * kBlock * kWayStep_s &&
           glm::length(resisted_n) > kLeastForce_n;
  }
};

// Finds the strokes of one attempt at 1 kHz.
class Watched {
 public:
  void Add(const core::CoreParams& params, const trace::Tick& tick) {
    dvec3 tip, bur, force;
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<size_t>(i);
      tip[i] = tick.input.counts[k] * (params.resolution_nm[k] * 1e-9);
      bur[i] = tick.witness.anchor_100nm[k] * 1e-7;
      force[i] = tick.witness.force_computed_mn[k] * -1e-3;
    }
    way_.push_back(tip);
    sum_n_ += force;
    if (way_.size() == 1) bur_ = bur;
    if (way_.size() % kBlock != 0) return;
    blocks_.push_back({bur - bur_, sum_n_ / static_cast<double>(kBlock)});
    bur_ = bur;
    sum_n_ = dvec3(0);
  }
  std::vector<ExerciseStroke> Strokes() const {
    std::vector<ExerciseStroke> out;
    size_t begin = 0, end = 0;  // end: behind the last block that removes
    for (size_t i = 0; i <= blocks_.size(); ++i) {
      const bool removes = i < blocks_.size() && blocks_[i].removes();
      const bool over = end > begin && (i == blocks_.size() || i - end > kMostRest);
      if (over || end - begin >= kLongest) {
        if (end - begin >= kShortest) out.push_back(Stroke(begin, end));
        begin = end = i;
      }
      if (!removes) continue;
      if (end == begin) begin = i;
      end = i + 1;
    }
    return out;
  }

 private:
  ExerciseStroke Stroke(size_t begin, size_t end) const {
    ExerciseStroke out;
    double work_j = 0, way2 = 0, way_m = 0;
    for (size_t i = begin; i < end; ++i) {
      const Block& b = blocks_[i];
      if (!b.removes()) continue;
      work_j += Dot(b.resisted_n, b.moved_m);
      way2 += Dot(b.moved_m, b.moved_m);
      way_m += glm::length(b.moved_m);
      out.seconds += kBlock * kWayStep_s;
    }
    out.b_n_s_per_m = work_j / way2 * (kBlock * kWayStep_s);
    out.speed_m_per_s = way_m / out.seconds;
    const auto at = way_.begin();
    out.way_m =
        Smoothed({at + static_cast<long>(begin * kBlock), at + static_cast<long>(end * kBlock)});
    const dvec3 from = out.way_m.front();
    for (dvec3& x : out.way_m) x -= from;
    return out;
  }

  std::vector<dvec3> way_;
  std::vector<Block> blocks_;
  dvec3 bur_{0}, sum_n_{0};
};

// The strokes at even shares of the time of all.
std::vector<ExerciseStroke> Spread(const std::vector<ExerciseStroke>& all, int each) {
  double whole_s = 0;
  for (const ExerciseStroke& s : all) whole_s += s.seconds;
  std::vector<ExerciseStroke> out;
  double passed_s = 0;
  for (const ExerciseStroke& s : all) {
    passed_s += s.seconds;
    int shares = 0;
    while (static_cast<int>(out.size()) + shares < each &&
           whole_s * (static_cast<double>(out.size()) + shares + 0.5) / each < passed_s)
      ++shares;
    for (int i = 0; i < shares; ++i) {
      out.push_back(s);
      out.back().seconds = whole_s / each;
    }
  }
  return out;
}

Result<std::vector<ExerciseStroke>> StrokesOn(const std::string& scene,
                                              const StrokesOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(const auto built, scene::BuildBuiltinScene(scene, kVoxel_nm));
  ENAMEL_ASSIGN_OR_RETURN(const auto profile, scene::FindProfile("pointer"));
  std::vector<ExerciseStroke> out;
  for (const scene::Exercise& exercise :
       scene::BuiltinExercises(built.scene, HashSha256(AsBytes(scene::ToJson(built.scene))))) {
    for (const std::string& person : options.people) {
      Watched watched;
      const auto done = RunOperator(
          *FindOperator(person), built, exercise, profile, 0, kMostTicks,
          [&](const auto& params, const trace::Tick& tick) { watched.Add(params, tick); });
      // Not every exercise can be planned on every tooth.
      if (!done.ok()) continue;
      const auto some = Spread(watched.Strokes(), options.each);
      for (size_t i = 0; i < some.size(); ++i) {
        out.push_back(some[i]);
        out.back().exercise = exercise.name;
        out.back().name = person + "-" + std::to_string(i + 1);
      }
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
    if (!some.ok()) return some.status();
    out.insert(out.end(), some->begin(), some->end());
  }
  return out;
}

}  // namespace enamel::station::lab
