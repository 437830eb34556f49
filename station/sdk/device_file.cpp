#include "station/sdk/device_file.h"

#include <sys/file.h>

#include <cerrno>
#include <filesystem>
#include <fstream>

#include "station/devices/device_node.h"
#include "station/devices/trouble.h"

namespace enamel::station::sdk {
namespace {

namespace fs = std::filesystem;

// The folder of the USB device itself, above those of its interface and of the driver's.
fs::path UsbFolder(const std::string& path) {
  std::error_code error;
  const std::string name = fs::path(path).filename();
  for (const char* kind : {"hidraw", "tty"}) {
    fs::path at = fs::canonical(fs::path("/sys/class") / kind / name / "device", error);
    for (; !error && at.has_relative_path(); at = at.parent_path()) {
      if (fs::exists(at / "idVendor", error)) return at;
    }
  }
  return {};
}

std::string Line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

}  // namespace

Result<std::unique_ptr<Fd>> OpenAlone(const std::string& path) {
  ENAMEL_ASSIGN_OR_RETURN(auto opened, OpenNode(path));
  if (::flock(opened->get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return Status(Code::kUnavailable,
                  path + " is in use: close the other program or window that uses this device",
                  trouble::kInUse);
  }
  return opened;
}

std::string UsbPlace(const std::string& path) { return UsbFolder(path).filename(); }

std::string UsbIds(const std::string& path) {
  const fs::path folder = UsbFolder(path);
  if (folder.empty()) return {};
  return Line(folder / "idVendor") + ":" + Line(folder / "idProduct");
}

}  // namespace enamel::station::sdk
