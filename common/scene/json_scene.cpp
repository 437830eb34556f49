#include <boost/json.hpp>

#include "common/scene/json.h"
#include "common/scene/json_read.h"
#include "common/scene/json_text.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

constexpr int64_t kFormat = 1;
constexpr int32_t kMaxExtentUm = 100'000;

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
    spec.damping_mn_s_per_mm =
        static_cast<int32_t>(item.Int("damping_mn_s_per_mm", 1, 1'000'000'000));
    spec.provenance = item.Text("provenance", 1, 500);
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
  if (!marks.Has("occlusal_centre")) marks.Refuse("occlusal_centre", "this landmark", "none");
  marks.Finish();
}

}  // namespace

std::string ToJson(const Scene& scene) {
  json::array tissues;
  for (const TissueSpec& t : scene.tissues) {
    tissues.push_back(json::object{{"tissue", cutting::TissueName(t.tissue)},
                                   {"damping_mn_s_per_mm", t.damping_mn_s_per_mm},
                                   {"provenance", t.provenance}});
  }
  json::object landmarks;
  for (const auto& [name, p] : scene.landmarks) landmarks[name] = json::array{p[0], p[1], p[2]};
  return CanonicalText(json::object{{"format", kFormat},
                                    {"name", scene.name},
                                    {"title", scene.title},
                                    {"volume_sha256", scene.volume.Hex()},
                                    {"voxel_nm", scene.voxel_nm},
                                    {"tissues", std::move(tissues)},
                                    {"landmarks_um", std::move(landmarks)},
                                    {"provenance", scene.provenance}});
}

Result<Scene> SceneFromJson(std::string_view text) {
  Result<json::value> document = ParseBounded(text);
  if (!document.ok()) return document.status();
  Status status;
  ObjectReader in(*document, "", status);
  Scene scene;
  in.Format(kFormat);
  scene.name = in.Name("name");
  scene.title = in.Text("title", 1, 200);
  scene.volume = in.Hash("volume_sha256");
  scene.voxel_nm = static_cast<int32_t>(in.Int("voxel_nm", 5'000, 1'000'000));
  ReadTissues(in, scene);
  ReadLandmarks(in, scene);
  scene.provenance = in.Text("provenance", 1, 2'000);
  in.Finish();
  if (!status.ok()) return status;
  return scene;
}

}  // namespace enamel::scene
