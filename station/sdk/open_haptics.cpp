#include <HD/hd.h>

#include "station/sdk/buses.h"

namespace enamel::station::sdk {
namespace {

// Its frame is x to the right, y up, z toward the user; positions in mm.
dvec3 ToScene(const HDdouble* v) { return {v[0], -v[2], v[1]}; }

bool Failed() { return HD_DEVICE_ERROR(hdGetError()); }

std::string ModelName() {
  const char* name = hdGetString(HD_DEVICE_MODEL_TYPE);
  return name == nullptr ? "OpenHaptics device" : name;
}

class OpenHaptics final : public PolledBus {
 public:
  explicit OpenHaptics(HHD device) : device_(device), name_(ModelName()) {}
  ~OpenHaptics() override { hdDisableDevice(device_); }
  std::string Name() const override { return name_; }
  std::string Driver() const override { return "openhaptics"; }

  Heard Read(Pose& out) override {
    HDdouble position[3] = {};
    HDint buttons = 0;
    hdMakeCurrentDevice(device_);
    hdBeginFrame(device_);
    hdGetDoublev(HD_CURRENT_POSITION, position);
    hdGetIntegerv(HD_CURRENT_BUTTONS, &buttons);
    hdEndFrame(device_);
    out.tip_m = ToScene(position) * 1e-3;
    out.pedal = (buttons & HD_DEVICE_BUTTON_1) != 0;
    return Failed() ? Heard::kGone : Heard::kPose;
  }
  bool Send(const dvec3& force_n) override {
    HDdouble force[3] = {force_n.x, force_n.z, -force_n.y};
    hdMakeCurrentDevice(device_);
    hdBeginFrame(device_);
    hdSetDoublev(HD_CURRENT_FORCE, force);
    hdEndFrame(device_);
    return !Failed();
  }

 private:
  const HHD device_;
  const std::string name_;
};

}  // namespace

Result<std::unique_ptr<PolledBus>> OpenOpenHaptics(const BusChoice&) {
  HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  if (Failed() || device == HD_INVALID_HANDLE) {
    return Status(Code::kUnavailable,
                  "OpenHaptics finds no device: connect it and run the maker's setup once",
                  "device");
  }
  hdEnable(HD_FORCE_OUTPUT);
  hdStartScheduler();
  return std::unique_ptr<PolledBus>(std::make_unique<OpenHaptics>(device));
}

std::vector<SdkDevice> FindOpenHaptics() {
  HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  if (Failed() || device == HD_INVALID_HANDLE) return {};
  std::string name = ModelName();
  hdDisableDevice(device);
  return {{"", name, ProfileNameOf(name), "", "", ""}};
}

}  // namespace enamel::station::sdk
