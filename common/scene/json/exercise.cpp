#include <algorithm>
#include <boost/json.hpp>

#include "common/core/params.h"
#include "common/scene/json/bur.h"
#include "common/scene/json/json.h"
#include "common/scene/json/kinds.h"
#include "common/scene/json/preparation.h"
#include "common/scene/json/read.h"
#include "common/scene/json/rubric.h"
#include "common/scene/json/text.h"
#include "common/scene/preparation.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

constexpr int32_t kMaxExtentUm = 100'000;

json::object TargetJson(const CavityTarget& t) {
  json::object out{{"landmark", t.landmark},
                   {"half_size_um", json::array{t.half_size_um[0], t.half_size_um[1]}},
                   {"depth_um", t.depth_um},
                   {"leeway_side_um", t.leeway_side_um},
                   {"leeway_bottom_um", t.leeway_bottom_um},
                   {"container_um", t.container_um}};
  if (!t.prepared.IsZero()) out["prepared_scene_sha256"] = t.prepared.Hex();
  if (t.parts.empty()) return out;
  json::array parts;
  for (const PreparationPart& part : t.parts) parts.push_back(PartJson(part));
  out["parts"] = std::move(parts);
  return out;
}

void ReadExerciseBur(ObjectReader& in, Exercise& e) {
  BurSpec bur = ReadNumberedBur(in.Object("bur"));
  e.bur_shape = bur.shape;
  e.bur_radius_um = bur.radius_um;
  e.bur_length_um = bur.length_um;
  e.bur_narrow_radius_um = bur.narrow_radius_um;
  e.bur_shank_radius_um = bur.shank_radius_um;
  e.bur_neck_um = bur.neck_um;
  e.bur_iso_number = bur.iso_number;
  if (!in.Has("other_burs")) return;
  for (ObjectReader& object : in.Objects("other_burs", 1, core::kMaxBurs - 1)) {
    e.other_burs.push_back(ReadNumberedBur(object));
  }
  for (size_t i = 0; i < e.other_burs.size(); ++i) {
    for (size_t j = 0; j <= i; ++j) {
      if (!e.other_burs[i].SameShapeAs(j == 0 ? e.bur() : e.other_burs[j - 1])) continue;
      in.Refuse("other_burs", "each bur once",
                "bur " + std::to_string(j) + " again as bur " + std::to_string(i + 1));
    }
  }
}

void ReadHandpiece(ObjectReader& in, Exercise& e) {
  // Without: its speed does not fall under load.
  if (!in.Has("handpiece")) return;
  ObjectReader object = in.Object("handpiece");
  e.handpiece.stall_un_m = static_cast<int32_t>(object.Int("stall_un_m", 1, 1'000'000));
  e.handpiece.tangential_permille =
      static_cast<int32_t>(object.Int("tangential_permille", 0, 10'000));
  e.handpiece.lag_us = static_cast<int32_t>(object.Int("lag_us", 0, 10'000'000));
  object.Finish();
}

json::object HandpieceJson(const HandpieceSpec& h) {
  return {{"stall_un_m", h.stall_un_m},
          {"tangential_permille", h.tangential_permille},
          {"lag_us", h.lag_us}};
}

void ReadTouchCues(ObjectReader& in, Exercise& e) {
  if (!in.Has("touch_cues")) return;
  ObjectReader object = in.Object("touch_cues");
  e.touch_cues.contact_mn = static_cast<int32_t>(object.Int("contact_mn", 0, 2'000));
  e.touch_cues.chatter_mn = static_cast<int32_t>(object.Int("chatter_mn", 0, 2'000));
  // From 1: without energy no cue is ever sent (haptics/touch_cues.h).
  e.touch_cues.energy_uj = static_cast<int32_t>(object.Int("energy_uj", 1, 1'000));
  e.touch_cues.power_uw = static_cast<int32_t>(object.Int("power_uw", 0, 10'000));
  if (e.touch_cues.contact_mn == 0 && e.touch_cues.chatter_mn == 0) {
    object.Refuse("contact_mn", "this or chatter_mn above 0, or no touch_cues at all", "0 and 0");
  }
  object.Finish();
}

json::object TouchCuesJson(const TouchCueSpec& c) {
  return {{"contact_mn", c.contact_mn},
          {"chatter_mn", c.chatter_mn},
          {"energy_uj", c.energy_uj},
          {"power_uw", c.power_uw}};
}

constexpr std::string_view kRubberDam = "rubber_dam";

void ReadIsolation(ObjectReader& in, Exercise& e) {
  if (!in.Has("isolation")) return;
  const std::string name = in.Name("isolation");
  if (name != kRubberDam) {
    in.Refuse("isolation", std::string(kRubberDam) + ", or no isolation at all",
              "\"" + name + "\"");
  }
  e.isolation = Isolation::kRubberDam;
}

void ReadLaw(ObjectReader& in, Exercise& e) {
  std::string name = in.Name("law");
  const haptics::LawEntry* law = haptics::FindLaw(std::string_view(name));
  if (law != nullptr) {
    e.law = law->kind;
    return;
  }
  std::string known;
  for (const haptics::LawEntry& entry : haptics::ForceLaws()) {
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  in.Refuse("law", "one of " + known, "\"" + name + "\"");
}

void ReadTarget(ObjectReader& in, CavityTarget& t) {
  ObjectReader target = in.Object("target");
  t.landmark = target.Name("landmark");
  auto half = target.Ints("half_size_um", 2, 1, kMaxExtentUm);
  // The third is the depth's to say.
  t.half_size_um = {half[0], half[1], 0};
  t.depth_um = static_cast<int32_t>(target.Int("depth_um", 1, kMaxExtentUm));
  t.leeway_side_um = static_cast<int32_t>(target.Int("leeway_side_um", 0, kMaxExtentUm));
  t.leeway_bottom_um = static_cast<int32_t>(target.Int("leeway_bottom_um", 0, kMaxExtentUm));
  t.container_um = static_cast<int32_t>(target.Int("container_um", 0, kMaxExtentUm));
  if (target.Has("parts")) {
    for (ObjectReader& part : target.Objects("parts", 1, kMaxParts))
      t.parts.push_back(ReadPart(part, Outlines::kAll));
    if (!HoldsItsParts(t)) {
      // Or the loop would leave tissue out of the plan that is to be cut.
      target.Refuse("parts", "parts within half_size_um and depth_um", "one that goes beyond");
    }
  }
  if (target.Has("prepared_scene_sha256")) {
    t.prepared = target.Hash("prepared_scene_sha256");
    if (!t.parts.empty()) target.Refuse("prepared_scene_sha256", "no parts beside it", "both");
  }
  target.Finish();
}

}  // namespace

std::string ToJson(const Exercise& e) {
  const haptics::LawEntry* law = haptics::FindLaw(e.law);
  // Exercises come from documents or from here: an unknown law was refused long before.
  ENAMEL_CHECK(law != nullptr);
  const bool handpiece = e.handpiece != HandpieceSpec{}, cues = e.touch_cues != TouchCueSpec{};
  json::object out{{kExerciseKind, kFormat},
                   {"name", e.name},
                   {"title", e.title},
                   {"instructions", e.instructions},
                   {"scene_sha256", e.scene.Hex()},
                   {"bur", NumberedBurJson(e.bur())}};
  if (!e.other_burs.empty()) {
    json::array burs;
    for (const BurSpec& bur : e.other_burs) burs.push_back(NumberedBurJson(bur));
    out["other_burs"] = std::move(burs);
  }
  if (handpiece) out["handpiece"] = HandpieceJson(e.handpiece);
  if (cues) out["touch_cues"] = TouchCuesJson(e.touch_cues);
  if (e.isolation == Isolation::kRubberDam) out["isolation"] = kRubberDam;
  out["law"] = law->name;
  out["rate_hz"] = e.rate_hz;
  out["time_limit_s"] = e.time_limit_s;
  out["graded"] = e.graded;
  out["target"] = TargetJson(e.target);
  out["rubric"] = RubricJson(e.rubric);
  return CanonicalText(out);
}

Result<Exercise> ExerciseFromJson(std::string_view text) {
  ENAMEL_ASSIGN_OR_RETURN(json::value document, ParseBounded(text));
  Status status;
  ObjectReader in(document, "", status);
  Exercise e;
  in.Format(kExerciseKind);
  e.name = in.Name("name");
  e.title = in.Text("title", 1, 200);
  e.instructions = in.Text("instructions", 0, 4'000);
  e.scene = in.Hash("scene_sha256");
  ReadExerciseBur(in, e);
  ReadHandpiece(in, e);
  ReadTouchCues(in, e);
  ReadIsolation(in, e);
  ReadLaw(in, e);
  e.rate_hz = static_cast<int32_t>(in.Int("rate_hz", 100, 20'000));
  e.time_limit_s = static_cast<int32_t>(in.Int("time_limit_s", 0, 86'400));
  e.graded = in.Bool("graded");
  ReadTarget(in, e.target);
  ObjectReader rubric = in.Object("rubric");
  e.rubric = ReadRubric(rubric);
  rubric.Finish();
  in.Finish();
  ENAMEL_RETURN_IF_ERROR(status);
  return e;
}

}  // namespace enamel::scene
