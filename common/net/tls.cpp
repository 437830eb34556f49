#include "common/net/tls.h"

#include <openssl/err.h>
#include <openssl/pem.h>

#include <boost/asio/ssl/context.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/file.h"
#include "common/net/certificate.h"

namespace enamel::net {
namespace {

namespace ssl = boost::asio::ssl;

constexpr size_t kMaxPemBytes = size_t{1} << 20;

Status Refused(const std::filesystem::path& file, const std::string& expected,
               const boost::system::error_code& error) {
  return Status(Code::kInvalidInput,
                file.string() + ": expected " + expected + "; OpenSSL says: " + error.message());
}

// Nobody is there to type a passphrase: without this, OpenSSL would ask for one.
int NoPassphrase(char*, int, int, void*) { return -1; }

// Refuses an encrypted key, and a chain in which the key's certificate is not the first. OpenSSL's own words for the two
// lead nobody to the fault.
Status MustFit(const std::filesystem::path& certificate, const Bytes& certificate_pem,
               const std::filesystem::path& private_key, const Bytes& key_pem) {
  const std::string_view text = AsText(key_pem);
  if (text.find("ENCRYPTED PRIVATE KEY") != std::string_view::npos ||
      text.find("Proc-Type: 4,ENCRYPTED") != std::string_view::npos) {
    return Status(Code::kInvalidInput,
                  private_key.string() +
                      ": expected a private key that is not encrypted, found one with a "
                      "passphrase, which nobody types when the server starts; write it without: "
                      "openssl pkey -in " +
                      private_key.string() +
                      " -out FILE, and let the server's user alone read FILE");
  }
  const std::unique_ptr<BIO, decltype(&BIO_free)> in(
      BIO_new_mem_buf(key_pem.data(), static_cast<int>(key_pem.size())), &BIO_free);
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(
      PEM_read_bio_PrivateKey(in.get(), nullptr, NoPassphrase, nullptr), &EVP_PKEY_free);
  ERR_clear_error();
  const size_t at = key ? CertificateOfKey(certificate_pem, key.get()) : 0;
  if (at <= 1) return Status::Ok();
  return Status(Code::kInvalidInput,
                certificate.string() + ": expected the certificate of " + private_key.string() +
                    " first, found it at place " + std::to_string(at) +
                    ": the chain is in the wrong order; put the server's own certificate first, "
                    "each signer's certificate after the one that it signed, and the root last "
                    "or not at all");
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
  ENAMEL_RETURN_IF_ERROR(MustFit(certificate, certificate_pem, private_key, key_pem));
  if (context->use_private_key(Buffer(key_pem), ssl::context::pem, error)) {
    return Refused(private_key, "the private key of " + certificate.string() + " in PEM form",
                   error);
  }
  return std::shared_ptr<SSL_CTX>(context, context->native_handle());
}

}  // namespace enamel::net
