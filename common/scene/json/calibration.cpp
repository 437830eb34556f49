#include "common/scene/calibration.h"

#include <array>
#include <boost/json.hpp>

#include "common/scene/json/kinds.h"
#include "common/scene/json/read.h"
#include "common/scene/json/text.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

// Far above any device: a bound against nonsense.
constexpr int64_t kMost = 1'000'000'000;
constexpr int64_t kEndOfYear9999Ms = 253'402'300'799'999;

struct Quantity {
  const char* name;
  std::optional<Measured> Calibration::*member;
};

// The order is that of the canonical document.
constexpr std::array<Quantity, 9> kQuantities = {{
    {"resolution_nm", &Calibration::resolution_nm},
    {"noise_nm", &Calibration::noise_nm},
    {"friction_mn", &Calibration::friction_mn},
    {"damping_mn_s_per_m", &Calibration::damping_mn_s_per_m},
    {"mass_g", &Calibration::mass_g},
    {"bus_delay_ticks", &Calibration::bus_delay_ticks},
    {"answer_us", &Calibration::answer_us},
    {"answer_jitter_us", &Calibration::answer_jitter_us},
    {"structural_mode_hz", &Calibration::structural_mode_hz},
}};

Measured ReadMeasured(ObjectReader& in, const char* name) {
  ObjectReader item = in.Object(name);
  Measured out;
  out.value = item.Int("value", 0, kMost);
  out.uncertainty = item.Int("uncertainty", 0, kMost);
  out.samples = item.Int("samples", 1, kMost);
  item.Finish();
  return out;
}

void ReadQuantities(ObjectReader& in, Calibration& into) {
  // Values that were not measured are left out: a 0 would be a claim.
  ObjectReader measured = in.Object("measured");
  bool any = false;
  for (const Quantity& quantity : kQuantities) {
    if (!measured.Has(quantity.name)) continue;
    into.*quantity.member = ReadMeasured(measured, quantity.name);
    any = true;
  }
  measured.Finish();
  if (!any) in.Refuse("measured", "at least one quantity", "none");
}

}  // namespace

std::string ToJson(const Calibration& calibration) {
  json::object measured;
  for (const Quantity& quantity : kQuantities) {
    const std::optional<Measured>& found = calibration.*quantity.member;
    if (!found) continue;
    measured[quantity.name] = json::object{
        {"value", found->value}, {"uncertainty", found->uncertainty}, {"samples", found->samples}};
  }
  return CanonicalText(json::object{{kCalibrationKind, kFormat},
                                    {"device", calibration.device},
                                    {"profile", calibration.profile},
                                    {"station", calibration.station},
                                    {"software", calibration.software},
                                    {"measured_ms", calibration.measured_ms},
                                    {"rate_hz", calibration.rate_hz},
                                    {"method", calibration.method},
                                    {"measured", std::move(measured)}});
}

Result<Calibration> CalibrationFromJson(std::string_view text) {
  ENAMEL_ASSIGN_OR_RETURN(json::value document, ParseBounded(text));
  Status status;
  ObjectReader in(document, "", status);
  Calibration out;
  // First: so that a newer format is reported as one, not as an unknown member.
  in.Format(kCalibrationKind);
  out.device = in.Text("device", 1, 200);
  out.profile = in.Name("profile");
  out.station = in.Text("station", 0, 200);
  out.software = in.Text("software", 1, 200);
  out.measured_ms = in.Int("measured_ms", 0, kEndOfYear9999Ms);
  out.rate_hz = in.Int("rate_hz", 100, 20'000);
  out.method = in.Text("method", 1, 2000);
  ReadQuantities(in, out);
  in.Finish();
  ENAMEL_RETURN_IF_ERROR(status);
  return out;
}

}  // namespace enamel::scene
