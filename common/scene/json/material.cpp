#include "common/scene/material.h"

#include <algorithm>

#include "common/scene/json/kinds.h"
#include "common/scene/json/read.h"

namespace enamel::scene {
namespace {

constexpr int64_t kMostDamping = 1'000'000'000, kMostForce = 100'000;
constexpr int32_t kAny = 2'000'000'000;

// For people only: it has to be there and to be a number.
void PassInterval(ObjectReader& in, const std::string& name, const std::string& unit) {
  in.Int(name + "_low" + unit, -kAny, kAny);
  in.Int(name + "_high" + unit, -kAny, kAny);
}

Material::Fitted ReadFitted(ObjectReader& in) {
  Material::Fitted out;
  out.name = in.Text("tissue", 1, 64);
  // A name that is no tissue of ours is kept: ApplyMaterial refuses it with the scene's own names
  // beside it.
  if (auto tissue = cutting::TissueFromName(out.name)) out.spec.tissue = *tissue;
  TissueSpec& spec = out.spec;
  spec.damping_mn_s_per_mm = static_cast<int32_t>(in.Int("damping_mn_s_per_mm", 1, kMostDamping));
  spec.provenance = in.Text("provenance", 1, 500);
  PassInterval(in, "damping", "_mn_s_per_mm");
  in.Int("offset_mn", -kAny, kAny);
  in.Int("residual_rms_mn", 0, kAny);
  // A fit from fewer is not written (station/lab/tissue/cut_solve.h).
  in.Int("blocks", 8, kAny);
  if (in.Has("axial_damping_mn_s_per_mm")) {
    spec.axial_damping_mn_s_per_mm =
        static_cast<int32_t>(in.Int("axial_damping_mn_s_per_mm", 1, kMostDamping));
    PassInterval(in, "axial_damping", "_mn_s_per_mm");
  }
  if (in.Has("damping_matrix_mn_s_per_mm")) {
    for (const char* name : {"damping_matrix_mn_s_per_mm", "damping_matrix_low_mn_s_per_mm",
                             "damping_matrix_high_mn_s_per_mm"})
      // Read to be checked and not used: the cutter has B along and across the bur alone.
      in.Ints(name, 6, -kAny, kAny);
  }
  if (in.Has("coulomb_mn")) {
    spec.coulomb_mn = static_cast<int32_t>(in.Int("coulomb_mn", 0, kMostForce));
    PassInterval(in, "coulomb", "_mn");
  }
  if (in.Has("threshold_mn")) {
    spec.threshold_mn = static_cast<int32_t>(in.Int("threshold_mn", 0, kMostForce));
    PassInterval(in, "threshold", "_mn");
    if (spec.threshold_mn < spec.coulomb_mn) {
      in.Refuse("threshold_mn", "at least coulomb_mn, " + std::to_string(spec.coulomb_mn),
                std::to_string(spec.threshold_mn));
    }
  }
  in.Finish();
  return out;
}

}  // namespace

Result<Material> MaterialFromJson(std::string_view text) {
  Result<boost::json::value> document = ParseBounded(text);
  if (!document.ok()) return document.status();
  Status status;
  ObjectReader in(*document, "", status);
  Material material;
  in.Format(kMaterialKind);
  material.source = in.Text("source", 1, 255);
  // Millihertz: recordings of a rate that is no whole number keep it.
  material.rate_mhz = in.Int("rate_mhz", 1, INT64_MAX);
  for (ObjectReader& item : in.Objects("tissues", 1, 64))
    material.tissues.push_back(ReadFitted(item));
  in.Finish();
  if (!status.ok()) return status;
  return material;
}

Status ApplyMaterial(const Material& material, Scene* scene) {
  // Into a copy, so that a material that does not fit leaves the scene as it was.
  std::vector<TissueSpec> tissues = scene->tissues;
  for (const Material::Fitted& fitted : material.tissues) {
    auto mine = std::find_if(tissues.begin(), tissues.end(), [&](const TissueSpec& t) {
      return t.tissue == fitted.spec.tissue && t.tissue != cutting::Tissue::kAir;
    });
    if (mine == tissues.end()) {
      std::string has;
      for (const TissueSpec& t : scene->tissues)
        has += (has.empty() ? "" : ", ") + std::string(cutting::TissueName(t.tissue));
      return Status(Code::kInvalidInput,
                    "material '" + material.source + "' has the tissue \"" + fitted.name +
                        "\", scene '" + scene->name + "' has " + has +
                        ": rename it in the profile, or leave it out",
                    fitted.name);
    }
    // The whole of it: a Coulomb part that was not measured must not stay from another source.
    *mine = fitted.spec;
  }
  scene->tissues = std::move(tissues);
  return Status::Ok();
}

}  // namespace enamel::scene
