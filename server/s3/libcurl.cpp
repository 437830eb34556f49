#include "server/s3/libcurl.h"

#include <dlfcn.h>

#include <string>

namespace enamel::s3 {
namespace {

// The name of every 7.x and 8.x; all since 7.85 have the functions used here
// (CURLOPT_PROTOCOLS_STR).
constexpr char kLibrary[] = "libcurl.so.4";

Result<Libcurl> Load() {
  // Never closed: connections may live until the program's end.
  void* library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    return Status(Code::kUnavailable, std::string("the library ") + kLibrary +
                                          ", which talks to S3 stores, cannot be opened (" +
                                          dlerror() + "); install Debian's package libcurl4");
  }
  Libcurl out{};
  const char* missing = nullptr;
  auto find = [&](auto& function, const char* name) {
    void* const found = dlsym(library, name);
    if (found == nullptr) missing = name;
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
  };
  find(out.global_init, "curl_global_init");
  find(out.easy_init, "curl_easy_init");
  find(out.easy_cleanup, "curl_easy_cleanup");
  find(out.easy_reset, "curl_easy_reset");
  find(out.easy_setopt, "curl_easy_setopt");
  find(out.easy_getinfo, "curl_easy_getinfo");
  find(out.easy_perform, "curl_easy_perform");
  find(out.easy_strerror, "curl_easy_strerror");
  find(out.slist_append, "curl_slist_append");
  find(out.slist_free_all, "curl_slist_free_all");
  if (missing != nullptr || out.global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) {
    return Status(Code::kUnavailable,
                  std::string("the library ") + kLibrary + " " +
                      (missing != nullptr ? std::string("has no ") + missing : "does not start") +
                      "; install Debian's package libcurl4 of version 7.88 or newer");
  }
  return out;
}

}  // namespace

Result<const Libcurl*> LoadLibcurl() {
  static const Result<Libcurl> kLoaded = Load();
  ENAMEL_RETURN_IF_ERROR(kLoaded.status());
  return &*kLoaded;
}

}  // namespace enamel::s3
