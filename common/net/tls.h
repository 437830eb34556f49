#pragma once

#include <filesystem>
#include <memory>

#include "common/base/result.h"

struct ssl_ctx_st;

// The server's TLS 1.3 context, for the station link and for the page.
namespace enamel::net {

// TLS 1.3 only (every browser since 2020 speaks it), certificate (chain) and key from PEM files, no
// client certificates. An idle connection keeps no record buffers. Shared, because every session
// refers to it. Thread safety: sessions may be made from any thread. Errors: kNotFound or kStorage
// (unreadable file), kInvalidInput (no PEM, an encrypted key, one of another certificate than the first).
Result<std::shared_ptr<ssl_ctx_st>> MakeServerContext(const std::filesystem::path& certificate,
                                                      const std::filesystem::path& private_key);

}  // namespace enamel::net
