#include <dhdc.h>

#include "station/sdk/buses.h"
#include "station/sdk/userward.h"

namespace enamel::station::sdk {
namespace {

dvec3 ToScene(double x, double y, double z) { return FromUserward({x, y, z}); }

// The handle's frame in the scene: ToScene turns both.
Quat ToScene(const double (&m)[3][3]) {
  // Columns of the scene's matrix: ToScene of the frame's image of each scene axis.
  const dvec3 x = ToScene(m[0][1], m[1][1], m[2][1]);
  const dvec3 y = -ToScene(m[0][0], m[1][0], m[2][0]);
  const dvec3 z = ToScene(m[0][2], m[1][2], m[2][2]);
  // The largest of the four is at least 1/2: no division by next to nothing (Shepperd, Journal of
  // Guidance and Control 1, 1978).
  const double w = 1 + x.x + y.y + z.z, a = 1 + x.x - y.y - z.z, b = 1 - x.x + y.y - z.z,
               c = 1 - x.x - y.y + z.z;
  Quat q;
  if (w >= a && w >= b && w >= c) {
    q = {y.z - z.y, z.x - x.z, x.y - y.x, w};
  } else if (a >= b && a >= c) {
    q = {a, x.y + y.x, z.x + x.z, y.z - z.y};
  } else if (b >= c) {
    q = {x.y + y.x, b, y.z + z.y, z.x - x.z};
  } else {
    q = {z.x + x.z, y.z + z.y, c, x.y - y.x};
  }
  return q.Normalised();
}

std::string NameOf(char id) {
  const char* name = dhdGetSystemName(id);
  return name == nullptr ? "Force Dimension device" : name;
}

class ForceDimension final : public PolledBus {
 public:
  explicit ForceDimension(char id)
      : id_(id), name_(NameOf(id)), turns_(dhdHasWrist(id)), twists_(dhdHasActiveWrist(id)) {}
  ~ForceDimension() override {
    // Before closing: afterwards nothing feeds the motors.
    dhdEnableForce(DHD_OFF, id_);
    dhdClose(id_);
  }
  std::string Name() const override { return name_; }
  std::string Driver() const override { return "dhd"; }

  Heard Read(Pose& out) override {
    double x = 0, y = 0, z = 0;
    if (dhdGetPosition(&x, &y, &z, id_) < 0) return Heard::kGone;
    out.tip_m = ToScene(x, y, z);
    if (turns_) {
      double frame[3][3] = {};
      if (dhdGetOrientationFrame(frame, id_) < 0) return Heard::kGone;
      out.orientation = ToScene(frame);
    }
    out.pedal = dhdGetButton(0, id_) == DHD_ON;
    return Heard::kPose;
  }
  bool Send(const dvec3& force_n) override {
    // DHD_MOTOR_SATURATED is no error: the motors gave what they have.
    const dvec3 f = ToUserward(force_n);
    return dhdSetForce(f.x, f.y, f.z, id_) >= 0;
  }
  bool SendWithTorque(const dvec3& force_n, const dvec3& torque_n_m) override {
    if (!twists_) return Send(force_n);
    const dvec3 f = ToUserward(force_n), t = ToUserward(torque_n_m);
    return dhdSetForceAndTorque(f.x, f.y, f.z, t.x, t.y, t.z, id_) >= 0;
  }

 private:
  const char id_;
  const std::string name_;
  const bool turns_, twists_;  // senses rotation, drives it
};

}  // namespace

Result<std::unique_ptr<PolledBus>> OpenForceDimension(const BusChoice&) {
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

std::vector<SdkDevice> FindForceDimension() {
  int id = dhdOpen();
  if (id < 0) return {};
  std::string name = NameOf(static_cast<char>(id));
  dhdClose(static_cast<char>(id));
  return {{"", name, ProfileNameOf(name), "", "", ""}};
}

}  // namespace enamel::station::sdk
