#include "station/sdk/open_sdk_device.h"

#include "station/sdk/buses.h"

namespace enamel::station::sdk {
namespace {

constexpr std::string_view kDhd = "dhd", kOpenHaptics = "openhaptics";

[[maybe_unused]] Status NotBuilt(std::string_view choice, const char* what) {
  return Status(Code::kUnavailable,
                "this program was built without " + std::string(what) + ", which '" +
                    std::string(choice) +
                    "' needs: install the maker's SDK and build again (station/sdk/README.md)",
                "device");
}

Result<std::unique_ptr<PolledBus>> OpenBus(std::string_view choice) {
  if (choice == kDhd) {
#ifdef ENAMEL_WITH_DHD
    return OpenForceDimension();
#else
    return NotBuilt(choice, "Force Dimension's SDK");
#endif
  }
  if (choice == kOpenHaptics) {
#ifdef ENAMEL_WITH_OPENHAPTICS
    return OpenOpenHaptics();
#else
    return NotBuilt(choice, "OpenHaptics");
#endif
  }
  return Status(Code::kInvalidInput,
                "expected dhd or openhaptics, found '" + std::string(choice) + "'", "device");
}

}  // namespace

bool IsSdkDevice(std::string_view choice) { return choice == kDhd || choice == kOpenHaptics; }

Result<std::unique_ptr<Device>> OpenSdkDevice(std::string_view choice,
                                              const scene::DeviceProfile& profile,
                                              std::function<void()> thread_setup) {
  auto bus = OpenBus(choice);
  if (!bus.ok()) return bus.status();
  double resolution_m = static_cast<double>(profile.resolution_nm.value) * 1e-9;
  return std::unique_ptr<Device>(
      std::make_unique<PolledDevice>(std::move(*bus), resolution_m, std::move(thread_setup)));
}

}  // namespace enamel::station::sdk
