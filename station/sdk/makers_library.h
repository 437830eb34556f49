#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "station/sdk/open_sdk_device.h"

namespace enamel::station::sdk {

// A maker's library, loaded while the program runs, so that one program serves computers with and without
// it. It stays loaded until the program ends, since its threads may. Thread safety: one thread at a time.
// Real-time: never.
class MakersLibrary {
 public:
  struct Names {
    const char* maker;   // "Force Dimension"
    const char* driver;  // as a command line names it
    // As the system's loader finds them, the preferred one first.
    std::array<const char*, 2> files;
    std::span<const DeviceNode> nodes;  // of its devices
    const char* install;                // what to install
  };
  // `file` names the library's file; empty: the first of `names.files` that there is. Errors:
  // kUnavailable, with what to install.
  static Result<MakersLibrary> Load(const Names& names, const std::string& file);

  // Sets `out` to the library's function of this name, or notes that it has none.
  template <typename Function>
  void Find(const char* name, Function*& out) {
    out = reinterpret_cast<Function*>(Symbol(name));
  }
  // Errors: kUnavailable, when a function was not found.
  Status Check() const;
  // Of a library whose version is too low: what to do.
  Status TooOld(const std::string& version, const char* expected) const;

 private:
  MakersLibrary(const Names& names, std::string file, void* handle)
      : names_(&names), file_(std::move(file)), handle_(handle) {}
  void* Symbol(const char* name);

  const Names* names_;
  std::string file_;
  void* handle_;
  std::string missing_;  // the first function that was not found
};

// The maker's devices on USB, by the system's list: they cannot be used, because `why`.
std::vector<SdkDevice> WithoutLibrary(const MakersLibrary::Names& names, const Status& why,
                                      const std::filesystem::path& usb = "/sys/bus/usb/devices");

// As WithoutLibrary, for a library that is there and opens none of them. A device whose file cannot be
// opened has that problem; the others have `why`.
std::vector<SdkDevice> NotOpened(const MakersLibrary::Names& names, const Status& why,
                                 const std::filesystem::path& usb = "/sys/bus/usb/devices");

}  // namespace enamel::station::sdk
