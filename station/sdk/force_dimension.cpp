#include <dhdc.h>

#include "station/sdk/buses.h"

namespace enamel::station::sdk {
namespace {

// Its frame is x toward the user, y to the right, z up.
dvec3 ToScene(double x, double y, double z) { return {y, -x, z}; }

std::string NameOf(char id) {
  const char* name = dhdGetSystemName(id);
  return name == nullptr ? "Force Dimension device" : name;
}

class ForceDimension final : public PolledBus {
 public:
  explicit ForceDimension(char id) : id_(id), name_(NameOf(id)) {}
  ~ForceDimension() override {
    dhdEnableForce(DHD_OFF, id_);
    dhdClose(id_);
  }
  std::string Name() const override { return name_; }

  bool Read(Pose& out) override {
    double x = 0, y = 0, z = 0;
    if (dhdGetPosition(&x, &y, &z, id_) < 0) return false;
    out.tip_m = ToScene(x, y, z);
    out.pedal = dhdGetButton(0, id_) == DHD_ON;
    return true;
  }
  bool Send(const dvec3& force_n) override {
    // The inverse of ToScene. DHD_MOTOR_SATURATED is no error: the motors gave what they have.
    return dhdSetForce(-force_n.y, force_n.x, force_n.z, id_) >= 0;
  }

 private:
  const char id_;
  const std::string name_;
};

}  // namespace

Result<std::unique_ptr<PolledBus>> OpenForceDimension() {
  int id = dhdOpen();
  if (id < 0) {
    return Status(Code::kUnavailable,
                  std::string("no Force Dimension device (") + dhdErrorGetLastStr() +
                      "): connect and switch it on, and allow its USB ids by udev",
                  "device");
  }
  dhdEnableForce(DHD_ON, static_cast<char>(id));
  return std::unique_ptr<PolledBus>(std::make_unique<ForceDimension>(static_cast<char>(id)));
}

std::optional<std::string> FindForceDimension() {
  int id = dhdOpen();
  if (id < 0) return std::nullopt;
  std::string name = NameOf(static_cast<char>(id));
  dhdClose(static_cast<char>(id));
  return name;
}

}  // namespace enamel::station::sdk
