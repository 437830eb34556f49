#pragma once

#include <filesystem>
#include <memory>

#include "common/base/result.h"

namespace boost::asio::ssl {
class context;
}

// TLS 1.3 contexts of the station link.
namespace enamel::net {

// For a server: TLS 1.3 only, certificate (chain) and key from PEM files, no client certificates.
// Shared, because every session's stream refers to it. Thread safety: streams may be made from any
// thread. Errors: kNotFound or kStorage (unreadable file), kInvalidInput (no PEM, or the key does
// not belong to the certificate).
Result<std::shared_ptr<boost::asio::ssl::context>> MakeServerContext(
    const std::filesystem::path& certificate, const std::filesystem::path& private_key);

}  // namespace enamel::net
