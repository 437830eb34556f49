#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "server/http/message.h"

namespace enamel::server::http {

// Whether an Accept-Encoding list names the coding, and not with q=0.
bool Accepts(std::string_view list, std::string_view coding);

// The page: every regular file under a folder, read into memory once. A request looks up one of the
// names found then, so no path can lead outside. A rebuilt page is served after a restart.
//
// `x.js.br` and `x.js.gz` are the compressed forms of `x.js`, chosen by Accept-Encoding. A hashed
// name (`main-4XKQ7B2D.js`) may be cached forever; index.html never; browsers ask again for
// anything else (ETag). Paths that look like no file are the page's own addresses. They get the
// index.html of the nearest folder above: `/attempts/x` that of `/attempts`, where it has one.
//
// Thread safety: const after Load. No I/O in Serve.
class StaticFiles {
 public:
  // Errors: kNotFound without folder or index.html, kTooLarge beyond 64 MiB together, kStorage.
  static Result<StaticFiles> Load(const std::filesystem::path& folder);

  // 200, 304, 404, or 405 for anything but GET and HEAD.
  Response Serve(const Request& request) const;

 private:
  struct File {
    std::string content_type;
    std::string cache_control;
    std::string etag;  // of the plain form
    std::shared_ptr<const std::string> plain, br, gz;
  };
  const File* Find(std::string_view path) const;

  std::map<std::string, File, std::less<>> files_;  // by path: "/assets/main-4XKQ7B2D.js"
};

}  // namespace enamel::server::http
