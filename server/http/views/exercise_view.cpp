#include "server/http/views/exercise_view.h"

#include <algorithm>
#include <map>

#include "common/base/mutex.h"
#include "common/scene/json/json.h"
#include "common/scene/json/preparation.h"
#include "common/scene/restoration.h"
#include "common/scoring/mistakes/prices.h"
#include "common/scoring/tolerances.h"
#include "server/training/access.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

json::object BurJson(const scene::BurSpec& bur) {
  return {{"shape", cutting::BurShapeName(bur.shape)},
          {"radius_um", bur.radius_um},
          {"length_um", bur.length_um},
          {"narrow_radius_um", bur.narrow_radius_um},
          {"shank_radius_um", bur.shank_radius_um},
          {"neck_um", bur.neck_um},
          {"iso_number", bur.iso_number}};
}

json::array BursJson(const scene::Exercise& exercise) {
  json::array out;
  for (const scene::BurSpec& bur : exercise.burs()) out.push_back(BurJson(bur));
  return out;
}

json::value HandpieceJson(const scene::HandpieceSpec& handpiece) {
  // null: the exercise uses no such model. Zeros would read as a handpiece that never turns.
  if (handpiece == scene::HandpieceSpec{}) return {};
  return {{"stall_un_m", handpiece.stall_un_m},
          {"tangential_permille", handpiece.tangential_permille},
          {"lag_us", handpiece.lag_us}};
}

json::value TouchCuesJson(const scene::TouchCueSpec& cues) {
  if (cues == scene::TouchCueSpec{}) return {};
  return {{"contact_mn", cues.contact_mn},
          {"chatter_mn", cues.chatter_mn},
          {"energy_uj", cues.energy_uj},
          {"power_uw", cues.power_uw}};
}

// Whose it is, for who teaches, and what the viewer may do with it, so that a page need not know the
// rules.
void AddSharing(const Person& viewer, const ExerciseRow& row, json::object& out) {
  json::value owner;
  if (!row.owner.IsZero() && CanEditExercises(viewer)) {
    owner = {{"id", row.owner.Text()}, {"display_name", row.owner_name}};
  }
  json::array may;
  if (CanChangeExercise(viewer, row)) may.emplace_back("change");
  if (CanUseExercise(viewer, row) && row.state == ExerciseState::kPublished) {
    may.emplace_back("assign");
  }
  if (CanUseExercise(viewer, row) && CanImportTeeth(viewer)) may.emplace_back("scan_target");
  out.emplace("owner", std::move(owner));
  out.emplace("shared", row.shared);
  out.emplace("may", std::move(may));
}

// Which tooth a target is in, which side is up, and where it hangs, in the scene's frame; null where
// the scene cannot be read, is no tooth or has no such point.
void AddPlace(StoredBlobs& blobs, const Sha256& scene, json::object& target) {
  target.emplace("tooth", nullptr);
  target.emplace("up", "occlusal");
  target.emplace("landmark_um", nullptr);
  const auto text = blobs.GetBlob(scene);
  if (!text.ok()) return;
  const auto document = scene::SceneFromJson(AsText(*text));
  if (!document.ok()) return;
  if (document->tooth != 0) target["tooth"] = document->tooth;
  if (document->up == scene::Up::kBuccal) target["up"] = "buccal";
  const auto found = document->landmarks.find(std::string(target.at("landmark").as_string()));
  if (found == document->landmarks.end()) return;
  const scene::PointUm& at = found->second;
  target["landmark_um"] = json::array{at[0], at[1], at[2]};
}

json::object TargetJson(const scene::CavityTarget& target) {
  const auto& half = target.half_size_um;
  json::array parts;
  for (const scene::PreparationPart& part : target.parts) parts.push_back(scene::PartJson(part));
  return {{"landmark", target.landmark},
          {"half_size_um", json::array{half[0], half[1], half[2]}},
          {"depth_um", target.depth_um},
          {"leeway_side_um", target.leeway_side_um},
          {"leeway_bottom_um", target.leeway_bottom_um},
          {"container_um", target.container_um},
          {"prepared", !target.prepared.IsZero()},
          {"parts", std::move(parts)}};
}

json::array MapJson(const std::vector<scene::RubricPoint>& map) {
  json::array out;
  for (const scene::RubricPoint& point : map) {
    out.push_back({{"value", point.value}, {"share", point.share}});
  }
  return out;
}

// The documents that were read, by their hash: a list of exercises would read and parse each of them
// for every request.
class ReadDocuments {
 public:
  std::optional<ExerciseDocument> Find(const Sha256& hash) {
    MutexLock lock(mutex_);
    const auto found = documents_.find(hash);
    return found == documents_.end() ? std::nullopt : std::optional(found->second);
  }
  void Add(const Sha256& hash, ExerciseDocument document) {
    MutexLock lock(mutex_);
    if (documents_.size() >= kMost) documents_.clear();
    documents_.emplace(hash, std::move(document));
  }

 private:
  static constexpr size_t kMost = 1024;  // of some kilobytes each
  Mutex mutex_;
  std::map<Sha256, ExerciseDocument> documents_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace

Result<ExerciseDocument> DocumentOf(StoredBlobs& blobs, const ExerciseRow& row) {
  static ReadDocuments read;
  if (auto known = read.Find(row.content)) return *known;
  ENAMEL_ASSIGN_OR_RETURN(const Bytes bytes, blobs.GetBlob(row.content));
  ENAMEL_ASSIGN_OR_RETURN(scene::Exercise exercise, scene::ExerciseFromJson(AsText(bytes)));
  auto document = std::make_shared<const scene::Exercise>(std::move(exercise));
  read.Add(row.content, document);
  return document;
}

json::object SummaryJson(const Person& viewer, const ExerciseRow& row,
                         const scene::Exercise& exercise, bool has_reference, int own_attempts) {
  json::object out{{"id", row.id.Text()},
                   {"name", row.name},
                   {"title", row.title},
                   {"version", row.version},
                   {"graded", row.graded},
                   {"instructions", exercise.instructions},
                   {"state", ExerciseStateName(row.state)},
                   {"revision", row.revision},
                   {"published_ms", row.published_ms},
                   {"time_limit_s", exercise.time_limit_s},
                   {"burs", BursJson(exercise)},
                   {"has_reference", has_reference || !exercise.target.prepared.IsZero()},
                   {"my_attempts", own_attempts}};
  AddSharing(viewer, row, out);
  return out;
}

void AddWhole(StoredBlobs& blobs, const ExerciseRow& row, const scene::Exercise& exercise,
              json::object& out) {
  out.emplace("law", haptics::FindLaw(exercise.law)->name);
  out.emplace("rate_hz", exercise.rate_hz);
  out.emplace("handpiece", HandpieceJson(exercise.handpiece));
  out.emplace("touch_cues", TouchCuesJson(exercise.touch_cues));
  out.emplace("rubber_dam", exercise.isolation == scene::Isolation::kRubberDam);
  out.emplace("scene_sha256", row.scene.Hex());
  out.emplace("document_sha256", row.content.Hex());
  json::object target = TargetJson(exercise.target);
  AddPlace(blobs, row.scene, target);
  out.emplace("target", std::move(target));
}

json::value RestorationJson(const scene::Rubric& rubric) {
  const auto tolerance = std::ranges::find(rubric.restorations, rubric.restoration,
                                           &scene::RestorationTolerance::restoration);
  if (tolerance == rubric.restorations.end()) return nullptr;
  return {{"name", scene::RestorationName(rubric.restoration)}, {"source", tolerance->source}};
}

json::array PricesJson(const scene::Rubric& rubric) {
  auto side = [](double size) { return size > 0 ? json::value(size) : json::value(); };
  json::array out;
  for (const scene::RubricPrice& price : rubric.prices) {
    out.push_back({{"of", price.of},
                   {"unit", scoring::UnitOf(price.of)},
                   {"over", side(price.over)},
                   {"left", side(price.left)},
                   {"points", price.points},
                   {"most", price.most},
                   {"modify_points", price.modify_points},
                   {"redo_points", price.redo_points},
                   {"source", price.source}});
  }
  return out;
}

json::object RubricJson(const scene::Rubric& written) {
  const scene::Rubric rubric = scoring::WithTolerances(written);
  json::array criteria, critical;
  for (const scene::RubricCriterion& criterion : rubric.criteria) {
    json::value fails_above;
    if (criterion.fails_above) fails_above = *criterion.fails_above;
    criteria.push_back({{"metric", criterion.metric},
                        {"title", criterion.title},
                        {"unit", criterion.unit},
                        {"points", criterion.points},
                        {"map", MapJson(criterion.map)},
                        {"fails_above", std::move(fails_above)},
                        {"comment", criterion.comment}});
  }
  for (const scene::RubricCritical& c : rubric.critical) {
    critical.push_back({{"error", c.error},
                        {"metric", c.metric},
                        {"unit", c.unit},
                        {"limit", c.limit},
                        {"above", c.above},
                        {"source", c.source}});
  }
  return {{"name", rubric.name},
          {"version", rubric.version},
          {"prices", PricesJson(rubric)},
          {"criteria", std::move(criteria)},
          {"critical", std::move(critical)},
          {"restoration", RestorationJson(rubric)}};
}

}  // namespace enamel::server::http
