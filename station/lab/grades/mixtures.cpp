#include "station/lab/grades/mixtures.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <random>

#include "common/scene/builder.h"
#include "common/scene/json/json.h"
#include "common/scoring/score.h"
#include "station/lab/grades/faults.h"
#include "station/lab/grades/sentences.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;
using scoring::AcceptableCut;

// Points: the rounding of their sums; a fault that an examiner would write down.
constexpr double kRounding = 1e-9, kWorthSaying = 1;
constexpr double kMm = 1e-3;
// Multiples of it fill a cube evenly: powers of the root of x^4 = x + 1 (Roberts, the R sequence).
constexpr dvec3 kSpread(0.8191725134, 0.6710436067, 0.5497004779);

// Over faults lie outside the task and left ones inside it, so that none undoes another.
struct RandomFault {
  std::string name;
  bool over = true;
  Hollow small, large;  // the second holds the first
};

Hollow Ball(const dvec3& middle, double radius_m) {
  return [=](const dvec3& p) {
    const dvec3 out = p - middle;
    return std::sqrt(Dot(out, out)) - radius_m;
  };
}
// A rod with round ends.
Hollow Rod(const dvec3& from, const dvec3& to, double radius_m) {
  return [=](const dvec3& p) {
    const dvec3 way = to - from, out = p - from;
    const double t = std::clamp(Dot(out, way) / Dot(way, way), 0.0, 1.0);
    const dvec3 rest = out - t * way;
    return std::sqrt(Dot(rest, rest)) - radius_m;
  };
}
Hollow Within(Hollow a, Hollow b) {
  return [a = std::move(a), b = std::move(b)](const dvec3& p) { return std::max(a(p), b(p)); };
}
Hollow Outside(Hollow a) {
  return [a = std::move(a)](const dvec3& p) { return -a(p); };
}

class Mixer {
 public:
  Mixer(const AcceptableCut& r, const Task& task, uint64_t seed)
      : r_(r), shape_(task), task_(HollowOf(task)), random_(seed) {}
  static Hollow HollowOf(const Task& task) {
    return [task](const dvec3& p) { return task.Distance_m(p); };
  }

  RandomFault Draw() {
    const auto& pieces = r_.pieces();
    const auto k = static_cast<size_t>(Uniform(0, static_cast<double>(pieces.size()) - 1e-6));
    const scoring::SurfacePiece& piece = pieces[k];
    const std::string at = " at " + r_.regions()[piece.region].name;
    const double radius = Uniform(0.2, 0.7) * kMm, more = Uniform(1.1, 1.7);
    const double depth = Uniform(0.1, 0.5) * kMm;
    // Towards the solid, by less than the radius.
    const dvec3 middle = piece.at_m - piece.normal * Uniform(-0.5, 0.5) * radius;
    const dvec3 along = glm::cross(piece.normal, dvec3(Uniform(-1, 1), Uniform(-1, 1), 1)) * kMm;
    const Hollow patch = Ball(piece.at_m, Uniform(0.6, 2.5) * kMm);
    auto layer = [&](double d) {
      return Hollow([task = shape_, d](const dvec3& p) { return task.GrownDistance_m(p, d); });
    };
    switch (static_cast<int>(Uniform(0, 5.999))) {
      case 0:
        return {"pit" + at, true, Ball(middle, radius), Ball(middle, radius * more)};
      case 1:
        return {"groove" + at, true, Rod(middle - along, middle + along, 0.6 * radius),
                Rod(middle - along, middle + along, 0.6 * radius * more)};
      case 2:
        return {"cut too far" + at, true, Within(layer(depth), patch),
                Within(layer(depth * more), patch)};
      case 3:
        return {"bump" + at, false, Ball(middle, radius), Ball(middle, radius * more)};
      case 4:
        return {"left" + at, false, Within(Outside(layer(-depth)), patch),
                Within(Outside(layer(-depth * more)), patch)};
      default:
        return {"everywhere too far", true, layer(0.5 * depth), layer(0.5 * depth * more)};
    }
  }

  // One more that meets none of the other kind: where something was left beside what was cut too far, a voxel has room
  // for one of the two, and the one mends a part of the other.
  RandomFault DrawApart(const std::vector<RandomFault>& others) {
    constexpr int kTries = 50;
    for (int i = 0; i < kTries; ++i) {
      RandomFault fault = Draw();
      const bool apart = std::ranges::none_of(
          others, [&](const RandomFault& o) { return o.over != fault.over && Meet(o, fault); });
      if (apart) return fault;
    }
    RandomFault same = Draw();
    while (!others.empty() && same.over != others.front().over) same = Draw();
    return same;
  }

  // `grown`: the fault that is the larger one.
  Hollow Cut(const std::vector<RandomFault>& faults, std::optional<size_t> grown = {}) const {
    Hollow out = task_;
    for (size_t i = 0; i < faults.size(); ++i) {
      if (faults[i].over) out = Both(out, i == grown ? faults[i].large : faults[i].small);
    }
    for (size_t i = 0; i < faults.size(); ++i) {
      if (faults[i].over) continue;
      const Hollow left = Within(i == grown ? faults[i].large : faults[i].small, task_);
      out = Within(out, Outside(left));
    }
    return out;
  }

  // The regions whose surface the fault moved by half a voxel and more.
  std::vector<bool> Reached(const RandomFault& fault) const {
    const double in_m = (fault.over ? -0.5 : 0.5) * r_.initial().spec().voxel_m();
    std::vector<bool> out(r_.regions().size());
    for (const scoring::SurfacePiece& piece : r_.pieces()) {
      if (fault.small(piece.at_m + piece.normal * in_m) < 0) out[piece.region] = true;
    }
    return out;
  }

  double Uniform(double from, double to) {
    return from + (to - from) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }

 private:
  bool Meet(const RandomFault& a, const RandomFault& b) const {
    const double near_m = 3 * r_.initial().spec().voxel_m();
    auto touches = [&](const RandomFault& fault, const scoring::SurfacePiece& piece) {
      const double side = fault.over ? -1 : 1;
      return fault.large(piece.at_m + piece.normal * (0.5 * side * near_m)) < near_m;
    };
    return std::ranges::any_of(r_.pieces(), [&](const scoring::SurfacePiece& piece) {
      return touches(a, piece) && touches(b, piece);
    });
  }

  const AcceptableCut& r_;
  const Task shape_;
  const Hollow task_;
  std::mt19937_64 random_;
};

struct Named {
  std::string scene;
  scene::Exercise exercise;
};

// One exercise at one size of voxel.
class Trial {
 public:
  static Result<std::unique_ptr<Trial>> Make(const scene::BuiltScene& built, const Named& named,
                                             int offsets) {
    ENAMEL_ASSIGN_OR_RETURN(const Task task, TaskOf(built, named.exercise));
    return std::unique_ptr<Trial>(new Trial(built, named, task, offsets));
  }

  Result<MixtureRow> Try(uint64_t seed) const {
    MixtureRow row;
    row.exercise = exercise_.name;
    row.voxel_mm = built_.scene.voxel_nm * 1e-6;
    row.seed = seed;
    Mixer mixer(r_, shape_, seed);
    std::vector<RandomFault> faults;
    const int count = 1 + static_cast<int>(mixer.Uniform(0, 2.999));
    for (int i = 0; i < count; ++i) faults.push_back(mixer.DrawApart(faults));
    for (const RandomFault& fault : faults) row.faults.push_back(fault.name);
    ENAMEL_ASSIGN_OR_RETURN(row.exact, Score(task_, row));
    std::vector<scoring::Mistake> mistakes;
    ENAMEL_ASSIGN_OR_RETURN(row.score, Score(mixer.Cut(faults), row, &mistakes));
    ENAMEL_RETURN_IF_ERROR(Compare(mixer, faults, mistakes, row));
    ENAMEL_ASSIGN_OR_RETURN(row.offset_spread, Spread(mixer.Cut(faults), row.score));
    for (size_t i = 0; i < faults.size(); ++i) {
      ENAMEL_ASSIGN_OR_RETURN(row.larger.emplace_back(), Score(mixer.Cut(faults, i), row));
      if (row.larger.back() > row.score + kRounding) {
        row.broken.push_back("a larger fault (" + faults[i].name + ") earns points");
      }
    }
    faults.push_back(mixer.DrawApart(faults));
    ENAMEL_ASSIGN_OR_RETURN(row.further, Score(mixer.Cut(faults), row));
    if (row.further > row.score + kRounding) {
      row.broken.push_back("a further fault (" + faults.back().name + ") earns points");
    }
    if (row.exact < 100) row.broken.emplace_back("the exact task loses points");
    if (row.sum_error > kRounding) row.broken.emplace_back("the mistakes do not sum to the loss");
    return row;
  }

 private:
  Trial(const scene::BuiltScene& built, const Named& named, const Task& task, int offsets)
      : built_(built),
        exercise_(named.exercise),
        shape_(task),
        task_(Mixer::HollowOf(task)),
        exact_(CutAway(built.volume, task_, Neighbours::kSpared)),
        r_(built.volume, exact_, {built.scene.tooth, built.scene.up}) {
    for (int i = 1; i <= offsets; ++i) {
      Shifted& shifted = shifted_.emplace_back();
      shifted.initial = std::make_unique<cutting::Volume>(InGridMoved(
          glm::fract(kSpread * static_cast<double>(i)), named.scene, built.scene.voxel_nm));
      shifted.exact =
          std::make_unique<cutting::Volume>(CutAway(*shifted.initial, task_, Neighbours::kSpared));
      shifted.r = std::make_unique<AcceptableCut>(
          *shifted.initial, *shifted.exact, scoring::ToothPlace{built.scene.tooth, built.scene.up});
    }
  }

  // Holds the same tooth and task at another place of the grid.
  struct Shifted {
    std::unique_ptr<cutting::Volume> initial, exact;
    std::unique_ptr<AcceptableCut> r;
  };
  static cutting::Volume InGridMoved(const dvec3& by_voxels, const std::string& scene,
                                     int32_t voxel_nm) {
    ivec3 by_nm(0);
    for (int a = 0; a < 3; ++a) by_nm[a] = static_cast<int>(std::lround(by_voxels[a] * voxel_nm));
    return scene::BuildBuiltinVolume(scene, voxel_nm, by_nm);
  }
  Result<double> Spread(const Hollow& taken, double score) const {
    double least = score, most = score;
    for (const Shifted& shifted : shifted_) {
      const cutting::Volume attempt = CutAway(*shifted.initial, taken, Neighbours::kSpared);
      ENAMEL_ASSIGN_OR_RETURN(const auto measured,
                              scoring::MeasureCut(*shifted.r, attempt, exercise_.rubric));
      const double points = 100 - std::min(100.0, measured.cost.sum);
      least = std::min(least, points), most = std::max(most, points);
    }
    return most - least;
  }

  // Compares the faults that were cut with the mistakes that the grade names.
  Status Compare(const Mixer& mixer, const std::vector<RandomFault>& faults,
                 const std::vector<scoring::Mistake>& mistakes, MixtureRow& row) const {
    std::vector<std::vector<bool>> reached;
    for (const RandomFault& fault : faults) {
      reached.push_back(mixer.Reached(fault));
      double alone = row.score;
      if (faults.size() > 1) {
        ENAMEL_ASSIGN_OR_RETURN(alone, Score(mixer.Cut({fault}), row));
      }
      if (alone > 100 - kWorthSaying) continue;
      ++row.asked;
      const bool found = std::ranges::any_of(mistakes, [&](const scoring::Mistake& m) {
        return m.points > 0 && Names(m, fault, reached.back());
      });
      found ? void(++row.found) : row.missed.push_back(fault.name);
    }
    for (const scoring::Mistake& m : mistakes) {
      row.lost += m.points;
      if (m.kind == scoring::MistakeKind::kUneven) row.uneven += m.points;
      if (m.points < kWorthSaying) continue;
      ++row.mistakes;
      bool made = false;
      for (size_t i = 0; i < faults.size(); ++i) made |= Names(m, faults[i], reached[i]);
      row.invented += !made;
    }
    return Status::Ok();
  }
  bool Names(const scoring::Mistake& m, const RandomFault& fault,
             const std::vector<bool>& reached) const {
    const Sides sides = SidesOf(m.kind);
    if (!(fault.over ? sides.over : sides.left)) return false;
    for (size_t i = 0; i < reached.size(); ++i) {
      if (reached[i] && IsAt(r_.regions()[i], m.place)) return true;
    }
    return false;
  }

  // Points of the cut alone. `mistakes`: filled where it is given.
  Result<double> Score(const Hollow& taken, MixtureRow& row,
                       std::vector<scoring::Mistake>* mistakes = nullptr) const {
    const cutting::Volume attempt = CutAway(built_.volume, taken, Neighbours::kSpared);
    ENAMEL_ASSIGN_OR_RETURN(const auto judged, scoring::JudgeCut(r_, attempt, exercise_.rubric));
    double points = 0;
    for (const auto& mistake : judged.found.mistakes) points += mistake.points;
    row.sum_error = std::max(row.sum_error, std::fabs(points - judged.cost.sum));
    const Sentences sentences =
        CheckSentences(r_, attempt, judged.measures, judged.cost.rows, judged.found.mistakes);
    row.sentences += sentences.said;
    row.wrong.insert(row.wrong.end(), sentences.wrong.begin(), sentences.wrong.end());
    if (mistakes != nullptr) *mistakes = judged.found.mistakes;
    return 100 - std::min(100.0, judged.cost.sum);
  }

  const scene::BuiltScene& built_;
  const scene::Exercise exercise_;
  const Task shape_;
  const Hollow task_;
  const cutting::Volume exact_;
  const AcceptableCut r_;
  std::vector<Shifted> shifted_;
};

// Names from coarse teeth, which are fast to build.
Result<std::vector<Named>> AskedFor(const std::vector<std::string>& names) {
  constexpr int32_t kCoarse_nm = 400'000;
  std::vector<Named> out;
  for (const std::string& scene : scene::BuiltinSceneNames()) {
    ENAMEL_ASSIGN_OR_RETURN(const auto built, scene::BuildBuiltinScene(scene, kCoarse_nm));
    for (auto& e :
         scene::BuiltinExercises(built.scene, HashSha256(AsBytes(scene::ToJson(built.scene))))) {
      const bool asked = names.empty() || std::ranges::any_of(names, [&](const std::string& n) {
                           return e.name.starts_with(n);
                         });
      if (asked) out.push_back({scene, std::move(e)});
    }
  }
  if (out.empty()) {
    return Status(Code::kNotFound,
                  "no built-in exercise has such a name: 'enamel-station scenes' lists them",
                  "exercise");
  }
  return out;
}

}  // namespace

Result<std::vector<MixtureRow>> TryMixtures(
    const MixturesOptions& options, const std::function<void(const MixtureRow&)>& row,
    const std::function<void(const std::string&, double)>& progress) {
  ENAMEL_ASSIGN_OR_RETURN(const auto exercises, AskedFor(options.exercises));
  std::vector<MixtureRow> rows;
  const size_t kinds = exercises.size() * options.voxels_nm.size();
  for (size_t v = 0; v < options.voxels_nm.size(); ++v) {
    std::string scene;
    std::optional<scene::BuiltScene> built;
    for (size_t e = 0; e < exercises.size(); ++e) {
      // In turn: the first ones have one more where the count does not divide.
      const size_t kind = v * exercises.size() + e;
      const auto all = static_cast<size_t>(options.count);
      const size_t count = all / kinds + (kind < all % kinds);
      if (count == 0) continue;
      if (scene != exercises[e].scene) {
        scene = exercises[e].scene;
        ENAMEL_ASSIGN_OR_RETURN(built, scene::BuildBuiltinScene(scene, options.voxels_nm[v]));
      }
      ENAMEL_ASSIGN_OR_RETURN(const auto trial, Trial::Make(*built, exercises[e], options.offsets));
      for (size_t i = 0; i < count; ++i) {
        if (progress) {
          progress(exercises[e].exercise.name,
                   static_cast<double>(rows.size()) / static_cast<double>(all));
        }
        ENAMEL_ASSIGN_OR_RETURN(rows.emplace_back(), trial->Try(options.seed + kinds * i + kind));
        if (row) row(rows.back());
      }
    }
  }
  return rows;
}

json::object MixturesJson(const std::vector<MixtureRow>& rows) {
  json::array out;
  double sum_error = 0;
  size_t broken = 0, sentences = 0, wrong = 0, asked = 0, found = 0, mistakes = 0, invented = 0;
  double lost = 0, uneven = 0;
  for (const MixtureRow& r : rows) {
    broken += r.broken.size();
    sentences += r.sentences;
    wrong += r.wrong.size();
    asked += r.asked, found += r.found;
    mistakes += r.mistakes, invented += r.invented;
    lost += r.lost, uneven += r.uneven;
    sum_error = std::max(sum_error, r.sum_error);
    out.push_back(json::object{{"exercise", r.exercise},
                               {"voxel_mm", r.voxel_mm},
                               {"seed", r.seed},
                               {"faults", json::value_from(r.faults)},
                               {"missed", json::value_from(r.missed)},
                               {"score", r.score},
                               {"larger", json::value_from(r.larger)},
                               {"further", r.further},
                               {"offset_spread", r.offset_spread},
                               {"exact", r.exact},
                               {"sum_error", r.sum_error},
                               {"sentences", r.sentences},
                               {"sentences_false", r.wrong.size()},
                               {"broken", json::value_from(r.broken)}});
  }
  return {{"format", 1},
          {"mixtures", rows.size()},
          {"laws_broken", broken},
          {"sum_error", sum_error},
          {"faults_asked", asked},
          {"faults_found", found},
          {"mistakes", mistakes},
          {"mistakes_invented", invented},
          {"uneven_share", lost > 0 ? uneven / lost : 0},
          {"sentences", sentences},
          {"sentences_false", wrong},
          {"rows", std::move(out)}};
}

}  // namespace enamel::station::lab
