#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "server/http/wire/http_server.h"

struct ssl_ctx_st;

namespace enamel::server::http {

// The page's certificate and key, read again when their files have changed: connections from then on
// get the new ones, and those that are open keep theirs. New files that cannot be used change
// nothing. The log says all of this, names a chain that is out of order, and warns once a day of a
// certificate that is not valid yet or ends within two weeks. Thread safety: Now and until_ms from any thread, Look from one.
class PageTls {
 public:
  // Errors: as of net::MakeServerContext.
  static Result<std::unique_ptr<PageTls>> Load(TlsFiles files);

  std::shared_ptr<ssl_ctx_st> Now() const;
  int64_t until_ms() const;  // Unix time
  // Whether the files have changed; takes them.
  void Look();

 private:
  explicit PageTls(TlsFiles files) : files_(std::move(files)) {}
  int64_t from_ms() const;
  // Of one state of both files.
  std::string Stamp() const;
  Status Read();
  void WarnOfEnd();

  const TlsFiles files_;
  std::string stamp_;  // Look's, and Load's
  std::chrono::steady_clock::time_point warned_{};
  mutable Mutex mutex_;
  std::shared_ptr<ssl_ctx_st> now_ ENAMEL_GUARDED_BY(mutex_);
  int64_t from_ms_ ENAMEL_GUARDED_BY(mutex_) = 0, until_ms_ ENAMEL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enamel::server::http
