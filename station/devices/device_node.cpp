#include "station/devices/device_node.h"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>

#include "station/devices/trouble.h"

namespace enamel::station {
namespace {

constexpr std::array kNodeKinds = {&kHidrawNode, &kAcmNode, &kUsbNode};

std::atomic<OpenCall> open_call{nullptr};

int CallOpen(const std::string& path) {
  // access(2) would not do: it does not ask the device controller of the unit's cgroup.
  constexpr int kFlags = O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC;
  const OpenCall call = open_call;
  return call == nullptr ? ::open(path.c_str(), kFlags) : call(path.c_str(), kFlags);
}

// Of a file of another kind, its name without the number: "ttyUSB".
std::string AllowedName(const std::string& path) {
  const auto kind = std::ranges::find_if(
      kNodeKinds, [&](const NodeKind* each) { return path.starts_with(each->path); });
  if (kind != kNodeKinds.end()) return std::string((*kind)->allowed);
  const std::string name = path.substr(path.rfind('/') + 1);
  return name.substr(0, name.find_last_not_of("0123456789") + 1);
}

Status Refused(const std::string& path, int error) {
  const auto because = [](const std::string& message, const char* field) {
    return Status(Code::kUnavailable, message, field);
  };
  switch (error) {
    case EACCES:
      return because(
          path +
              " may not be used by you: /usr/lib/udev/rules.d/60-enamel.rules gives the "
              "devices it lists to the group plugdev and to whoever sits here; an admin adds "
              "a line for another in /etc/udev/rules.d/61-enamel.rules. Then plug it in "
              "again",
          trouble::kPermission);
    case EPERM:
      return because(path +
                         " is of a kind that the unit of this program does not list: an admin runs "
                         "'systemctl edit enamel-station', adds 'DeviceAllow=char-" +
                         AllowedName(path) +
                         " rw' below [Service], and restarts enamel-station.service",
                     trouble::kConfined);
    case EBUSY:
      return because(path + " is in use: close the other program or window that uses this device",
                     trouble::kInUse);
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return because("cannot open " + path + " (" + std::strerror(error) + "): plug the device in",
                     trouble::kNotAttached);
    default:
      return because(
          "cannot open " + path + " (" + std::strerror(error) + "): plug the device in again",
          trouble::kDevice);
  }
}

}  // namespace

Result<std::unique_ptr<Fd>> OpenNode(const std::string& path) {
  const int fd = CallOpen(path);
  if (fd < 0) return Refused(path, errno);
  return std::make_unique<Fd>(fd);
}

Status WhyNotOpenable(const std::string& path) { return OpenNode(path).status(); }

void SetOpenCall(OpenCall call) { open_call = call; }

}  // namespace enamel::station
