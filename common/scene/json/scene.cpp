#include <boost/json.hpp>

#include "common/scene/json/bur.h"
#include "common/scene/json/json.h"
#include "common/scene/json/kinds.h"
#include "common/scene/json/preparation.h"
#include "common/scene/json/read.h"
#include "common/scene/json/text.h"
#include "common/scene/json/tissue.h"
#include "common/scene/tooth_number.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

constexpr std::string_view kOcclusal = "occlusal", kBuccal = "buccal";
constexpr int32_t kMaxExtentUm = 100'000;
constexpr size_t kMaxBurs = 64, kMaxPreparations = 64;

cutting::Tissue ReadTissueName(ObjectReader& in) {
  std::string name = in.Name("tissue");
  auto tissue = cutting::TissueFromName(name);
  if (tissue && *tissue != cutting::Tissue::kAir) return *tissue;
  in.Refuse("tissue", "enamel, dentin, pulp, caries, filling, gypsum or neighbour",
            "\"" + name + "\"");
  return cutting::Tissue::kEnamel;
}

void ReadTissues(ObjectReader& in, Scene& scene) {
  std::set<cutting::Tissue> seen;
  for (ObjectReader& item : in.Objects("tissues", 1, cutting::kTissueCount - 1)) {
    TissueSpec spec;
    spec.tissue = ReadTissueName(item);
    ReadTissueLaw(item, spec);
    spec.provenance = item.Text("provenance", 1, 500);
    // Two would make the force depend on which a reader takes.
    if (!seen.insert(spec.tissue).second) {
      item.Refuse("tissue", "each tissue once",
                  std::string(cutting::TissueName(spec.tissue)) + " twice");
    }
    item.Finish();
    scene.tissues.push_back(std::move(spec));
  }
}

void ReadLandmarks(ObjectReader& in, Scene& scene) {
  ObjectReader marks = in.Object("landmarks_um");
  for (const std::string& name : marks.Names()) {
    auto p = marks.Ints(name, 3, -kMaxExtentUm, kMaxExtentUm);
    scene.landmarks[name] = {p[0], p[1], p[2]};
  }
  // The one that every scene has: device and camera are placed by it.
  if (!marks.Has("occlusal_centre")) marks.Refuse("occlusal_centre", "this landmark", "none");
  marks.Finish();
}

void ReadBurs(ObjectReader& in, Scene& scene) {
  for (ObjectReader& item : in.Objects("burs", 0, kMaxBurs)) {
    BurSpec bur = ReadBur(item);
    // A scene's burs are chosen by name; an exercise has one and no name for it.
    bur.name = item.Name("name");
    for (const BurSpec& other : scene.burs) {
      if (other.name == bur.name) item.Refuse("name", "each bur once", bur.name + " twice");
    }
    item.Finish();
    scene.burs.push_back(std::move(bur));
  }
}

void ReadPreparations(ObjectReader& in, Scene& scene) {
  for (ObjectReader& item : in.Objects("preparations", 0, kMaxPreparations)) {
    Preparation p;
    p.name = item.Name("name");
    for (const Preparation& other : scene.preparations) {
      if (other.name == p.name) item.Refuse("name", "each preparation once", p.name + " twice");
    }
    p.title = item.Text("title", 1, 200);
    for (ObjectReader& part : item.Objects("parts", 1, kMaxParts))
      p.parts.push_back(ReadPart(part, Outlines::kBoxesAndDiscs));
    item.Finish();
    scene.preparations.push_back(std::move(p));
  }
}

json::array BursJson(const std::vector<BurSpec>& burs) {
  json::array out;
  for (const BurSpec& bur : burs) {
    json::object named{{"name", bur.name}};
    // The name first, as the canonical order has it.
    for (const auto& member : BurJson(bur)) named.insert(member);
    out.push_back(std::move(named));
  }
  return out;
}

json::array PreparationsJson(const std::vector<Preparation>& preparations) {
  json::array out;
  for (const Preparation& p : preparations) {
    json::array parts;
    for (const PreparationPart& part : p.parts) parts.push_back(PartJson(part));
    out.push_back(json::object{{"name", p.name}, {"title", p.title}, {"parts", std::move(parts)}});
  }
  return out;
}

}  // namespace

std::string ToJson(const Scene& scene) {
  json::array tissues;
  for (const TissueSpec& t : scene.tissues) {
    json::object tissue{{"tissue", cutting::TissueName(t.tissue)}};
    WriteTissueLaw(t, tissue);
    tissue["provenance"] = t.provenance;
    tissues.push_back(std::move(tissue));
  }
  json::object landmarks;
  // A map, so in the order of their names: the text does not depend on who added which first.
  for (const auto& [name, p] : scene.landmarks) landmarks[name] = json::array{p[0], p[1], p[2]};
  json::object out{{kSceneKind, kFormat}, {"name", scene.name}, {"title", scene.title}};
  if (scene.tooth != 0) out["tooth"] = scene.tooth;
  const json::object rest{{"volume_sha256", scene.volume.Hex()},
                          {"voxel_nm", scene.voxel_nm},
                          {"tissues", std::move(tissues)},
                          {"landmarks_um", std::move(landmarks)},
                          {"burs", BursJson(scene.burs)},
                          {"preparations", PreparationsJson(scene.preparations)},
                          {"up", scene.up == Up::kBuccal ? kBuccal : kOcclusal},
                          {"provenance", scene.provenance}};
  for (const auto& member : rest) out.insert(member);
  return CanonicalText(out);
}

Result<Scene> SceneFromJson(std::string_view text) {
  ENAMEL_ASSIGN_OR_RETURN(json::value document, ParseBounded(text));
  Status status;
  ObjectReader in(document, "", status);
  Scene scene;
  in.Format(kSceneKind);
  scene.name = in.Name("name");
  scene.title = in.Text("title", 1, 200);
  if (in.Has("tooth")) {
    scene.tooth = static_cast<int32_t>(in.Int("tooth", 11, 85));
    if (!IsToothNumber(scene.tooth)) {
      in.Refuse("tooth", "an FDI number, 11 to 48 or 51 to 85", std::to_string(scene.tooth));
    }
  }
  scene.volume = in.Hash("volume_sha256");
  scene.voxel_nm = static_cast<int32_t>(in.Int("voxel_nm", 5'000, 1'000'000));
  ReadTissues(in, scene);
  ReadLandmarks(in, scene);
  ReadBurs(in, scene);
  ReadPreparations(in, scene);
  const std::string up = in.Name("up");
  if (up != kOcclusal && up != kBuccal) {
    in.Refuse("up", "occlusal or buccal", "\"" + up + "\"");
  }
  scene.up = up == kBuccal ? Up::kBuccal : Up::kOcclusal;
  scene.provenance = in.Text("provenance", 1, 2'000);
  in.Finish();
  ENAMEL_RETURN_IF_ERROR(status);
  return scene;
}

}  // namespace enamel::scene
