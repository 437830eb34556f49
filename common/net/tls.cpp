#include "common/net/tls.h"

#include <boost/asio/ssl/context.hpp>

#include "common/base/file.h"

namespace enamel::net {
namespace {

namespace ssl = boost::asio::ssl;

constexpr size_t kMaxPemBytes = size_t{1} << 20;

Status Refused(const std::filesystem::path& file, const std::string& expected,
               const boost::system::error_code& error) {
  return Status(Code::kInvalidInput,
                file.string() + ": expected " + expected + "; OpenSSL says: " + error.message());
}

boost::asio::const_buffer Buffer(const Bytes& bytes) { return {bytes.data(), bytes.size()}; }

}  // namespace

Result<std::shared_ptr<SSL_CTX>> MakeServerContext(const std::filesystem::path& certificate,
                                                   const std::filesystem::path& private_key) {
  ENAMEL_ASSIGN_OR_RETURN(auto certificate_pem, ReadFile(certificate, kMaxPemBytes));
  ENAMEL_ASSIGN_OR_RETURN(auto key_pem, ReadFile(private_key, kMaxPemBytes));

  auto context = std::make_shared<ssl::context>(ssl::context::tls_server);
  ENAMEL_CHECK(SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_3_VERSION) == 1);
  SSL_CTX_set_mode(context->native_handle(), SSL_MODE_RELEASE_BUFFERS |
                                                 SSL_MODE_ENABLE_PARTIAL_WRITE |
                                                 SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  boost::system::error_code error;
  // The certificate first: OpenSSL then refuses a key that does not belong to it.
  if (context->use_certificate_chain(Buffer(certificate_pem), error)) {
    return Refused(certificate, "a certificate in PEM form", error);
  }
  if (context->use_private_key(Buffer(key_pem), ssl::context::pem, error)) {
    return Refused(private_key, "the private key of " + certificate.string() + " in PEM form",
                   error);
  }
  return std::shared_ptr<SSL_CTX>(context, context->native_handle());
}

}  // namespace enamel::net
