#include "station/sdk/makers_library.h"

#include <dlfcn.h>

#include <algorithm>
#include <fstream>
#include <string_view>

#include "station/devices/trouble.h"

namespace enamel::station::sdk {
namespace {

namespace fs = std::filesystem;

std::string Word(const fs::path& file) {
  std::ifstream in(file);
  std::string word;
  in >> word;
  return word;
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
  std::vector<SdkDevice> out;
  std::error_code error;
  for (const auto& device : fs::directory_iterator(usb, error)) {
    const std::string ids =
        Word(device.path() / "idVendor") + ":" + Word(device.path() / "idProduct");
    const bool fits = std::ranges::any_of(names.usb_ids, [&](std::string_view begin) {
      return !begin.empty() && ids.starts_with(begin);
    });
    if (fits) out.push_back({"", std::string(names.maker) + " device", "", ids, "", why});
  }
  std::ranges::sort(out, {}, &SdkDevice::ids);
  return out;
}

}  // namespace enamel::station::sdk
