#include "station/sdk/answering.h"

#include <cmath>

namespace enamel::station::sdk {

Status SaysNothing(const std::string& name) {
  return Status(Code::kUnavailable,
                name + " sends no pose within a second: switch it on, and plug it in again",
                "device");
}

Status CheckHome(const std::string& name, const dvec3& tip_m, double reach_m,
                 const char* how_to_home) {
  const double off_m = std::sqrt(Dot(tip_m, tip_m));
  if (off_m <= reach_m) return Status::Ok();
  return Status(
      Code::kUnavailable,
      name + " puts its tip " + std::to_string(std::lround(off_m * 1e3)) +
          " mm from the middle of its workspace, which reaches " +
          std::to_string(std::lround(reach_m * 1e3)) +
          " mm: move it there. If it is there, its encoders are not calibrated: " + how_to_home,
      "device");
}

}  // namespace enamel::station::sdk
