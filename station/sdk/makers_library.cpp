#include "station/sdk/makers_library.h"

#include <dlfcn.h>

#include <algorithm>
#include <fstream>
#include <string_view>

#include "station/devices/trouble.h"
#include "station/sdk/device_file.h"

namespace enamel::station::sdk {
namespace {

namespace fs = std::filesystem;

std::string Word(const fs::path& file) {
  std::ifstream in(file);
  std::string word;
  in >> word;
  return word;
}

std::string Padded(const std::string& number) {
  return std::string(3 - std::min<size_t>(number.size(), 3), '0') + number;
}

// The device files that the library opens for the USB device of this folder in /sys.
std::vector<std::string> FilesOf(const MakersLibrary::Names& names, const fs::path& device) {
  std::vector<std::string> out;
  std::error_code error;
  for (const DeviceNode& node : names.nodes) {
    if (node.kind == &kUsbNode) {
      out.push_back(std::string(kUsbNode.path) + Padded(Word(device / "busnum")) + "/" +
                    Padded(Word(device / "devnum")));
      continue;
    }
    for (const auto& each :
         fs::directory_iterator(fs::path("/sys/class") / node.kind->subsystem, error)) {
      const std::string file = "/dev/" + each.path().filename().string();
      if (file.starts_with(node.kind->path) && UsbPlace(file) == device.filename()) {
        out.push_back(file);
      }
    }
  }
  return out;
}

// The devices with the ids of `names`, each with its problem by its folder in /sys.
template <typename Problem>
std::vector<SdkDevice> OnUsb(const MakersLibrary::Names& names, const fs::path& usb,
                             Problem problem) {
  std::vector<SdkDevice> out;
  std::error_code error;
  for (const auto& device : fs::directory_iterator(usb, error)) {
    const std::string ids =
        Word(device.path() / "idVendor") + ":" + Word(device.path() / "idProduct");
    const bool fits = std::ranges::any_of(
        names.nodes, [&](const DeviceNode& node) { return ids.starts_with(node.ids); });
    if (!fits) continue;
    out.push_back({"", std::string(names.maker) + " device", "", ids, "", problem(device.path())});
  }
  std::ranges::sort(out, {}, &SdkDevice::ids);
  return out;
}

}  // namespace

Result<MakersLibrary> MakersLibrary::Load(const Names& names, const std::string& file) {
  std::string why;
  for (const char* name : names.files) {
    const std::string wanted = file.empty() ? name : file;
    if (void* handle = ::dlopen(wanted.c_str(), RTLD_NOW | RTLD_LOCAL); handle != nullptr) {
      return MakersLibrary(names, wanted, handle);
    }
    if (why.empty()) why = ::dlerror();
    if (!file.empty()) break;
  }
  return Status(Code::kUnavailable,
                std::string("the library of ") + names.maker + " cannot be loaded (" + why +
                    "): install " + names.install + ", or name the library's file (" +
                    names.driver + ":/FOLDER/" + names.files[0] + ")",
                trouble::kLibrary);
}

void* MakersLibrary::Symbol(const char* name) {
  void* found = ::dlsym(handle_, name);
  if (found == nullptr && missing_.empty()) missing_ = name;
  return found;
}

Status MakersLibrary::Check() const {
  if (missing_.empty()) return Status::Ok();
  return Status(Code::kUnavailable,
                std::string("the library of ") + names_->maker + " (" + file_ +
                    ") has no function " + missing_ + ": install a newer version of " +
                    names_->install,
                trouble::kLibrary);
}

Status MakersLibrary::TooOld(const std::string& version, const char* expected) const {
  return Status(Code::kUnavailable,
                std::string("the library of ") + names_->maker + " (" + file_ + ") is version " +
                    version + ", expected " + expected + " or newer: install a newer version of " +
                    names_->install,
                trouble::kLibrary);
}

std::vector<SdkDevice> WithoutLibrary(const MakersLibrary::Names& names, const Status& why,
                                      const fs::path& usb) {
  return OnUsb(names, usb, [&](const fs::path&) { return why; });
}

std::vector<SdkDevice> NotOpened(const MakersLibrary::Names& names, const Status& why,
                                 const fs::path& usb) {
  return OnUsb(names, usb, [&](const fs::path& device) {
    for (const std::string& file : FilesOf(names, device)) {
      ENAMEL_RETURN_IF_ERROR(WhyNotOpenable(file));
    }
    return why;
  });
}

}  // namespace enamel::station::sdk
