#include "common/scene/material.h"

#include <algorithm>

#include "common/scene/json/kinds.h"
#include "common/scene/json/read.h"
#include "common/scene/json/text.h"
#include "common/scene/json/tissue.h"

namespace enamel::scene {
namespace {

constexpr int32_t kAny = 2'000'000'000;

// For people only: what is there has to be numbers.
void PassInterval(ObjectReader& in, const std::string& name, const std::string& unit) {
  in.Int(name + "_low" + unit, -kAny, kAny);
  in.Int(name + "_high" + unit, -kAny, kAny);
}

void PassFit(ObjectReader in) {
  PassInterval(in, "damping", "_mn_s_per_mm");
  in.Int("offset_mn", -kAny, kAny);
  in.Int("residual_rms_mn", 0, kAny);
  // A fit from fewer is not written (station/lab/tissue/cut_solve.h).
  in.Int("blocks", 8, kAny);
  if (in.Has("axial_damping_low_mn_s_per_mm")) PassInterval(in, "axial_damping", "_mn_s_per_mm");
  if (in.Has("coulomb_low_mn")) PassInterval(in, "coulomb", "_mn");
  if (in.Has("bur_friction_low_permille")) PassInterval(in, "bur_friction", "_permille");
  if (in.Has("damping_matrix_mn_s_per_mm")) {
    for (const char* name : {"damping_matrix_mn_s_per_mm", "damping_matrix_low_mn_s_per_mm",
                             "damping_matrix_high_mn_s_per_mm"})
      // The cutter has B along and across the bur alone.
      in.Ints(name, 6, -kAny, kAny);
  }
  in.Finish();
}

Material::Named ReadNamed(ObjectReader& in) {
  Material::Named out;
  out.name = in.Text("tissue", 1, 64);
  // A name that is no tissue of ours is kept: ApplyMaterial refuses it with the scene's own names
  // beside it.
  if (auto tissue = cutting::TissueFromName(out.name)) out.spec.tissue = *tissue;
  ReadTissueLaw(in, out.spec);
  out.spec.provenance = in.Text("provenance", 1, 500);
  if (in.Has("fit")) PassFit(in.Object("fit"));
  in.Finish();
  return out;
}

}  // namespace

Result<Material> MaterialFromJson(std::string_view text) {
  ENAMEL_ASSIGN_OR_RETURN(boost::json::value document, ParseBounded(text));
  Status status;
  ObjectReader in(document, "", status);
  Material material;
  in.Format(kMaterialKind);
  material.source = in.Text("source", 1, 255);
  // The rate of the recording that was fitted, in millihertz: a rate that is no whole number keeps what it has.
  if (in.Has("rate_mhz")) in.Int("rate_mhz", 1, INT64_MAX);
  for (ObjectReader& item : in.Objects("tissues", 1, 64))
    material.tissues.push_back(ReadNamed(item));
  in.Finish();
  ENAMEL_RETURN_IF_ERROR(status);
  return material;
}

std::string ToJson(const Material& material) {
  boost::json::array tissues;
  for (const Material::Named& named : material.tissues) {
    boost::json::object tissue{{"tissue", named.name}};
    WriteTissueLaw(named.spec, tissue);
    tissue["provenance"] = named.spec.provenance;
    tissues.push_back(std::move(tissue));
  }
  return CanonicalText(boost::json::object{
      {kMaterialKind, kFormat}, {"source", material.source}, {"tissues", std::move(tissues)}});
}

Status ApplyMaterial(const Material& material, Scene* scene) {
  // Into a copy, so that a material that does not fit leaves the scene as it was.
  std::vector<TissueSpec> tissues = scene->tissues;
  for (const Material::Named& named : material.tissues) {
    auto mine = std::find_if(tissues.begin(), tissues.end(), [&](const TissueSpec& t) {
      return t.tissue == named.spec.tissue && t.tissue != cutting::Tissue::kAir;
    });
    if (mine == tissues.end()) {
      std::string has;
      for (const TissueSpec& t : scene->tissues)
        has += (has.empty() ? "" : ", ") + std::string(cutting::TissueName(t.tissue));
      return Status(Code::kInvalidInput,
                    "material '" + material.source + "' has the tissue \"" + named.name +
                        "\", scene '" + scene->name + "' has " + has +
                        ": rename it in the profile, or leave it out",
                    named.name);
    }
    // The whole of it: a Coulomb part that was not measured must not stay from another source.
    *mine = named.spec;
  }
  scene->tissues = std::move(tissues);
  return Status::Ok();
}

}  // namespace enamel::scene
