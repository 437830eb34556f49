#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <memory>

#include "tests/server/http/running_server.h"
#include "tests/support/becomes.h"

namespace enamel::server::http {
namespace {

template <auto Free>
struct Freed {
  template <typename T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using File = std::unique_ptr<FILE, Freed<std::fclose>>;
using Context = std::unique_ptr<SSL_CTX, Freed<SSL_CTX_free>>;
using Tls = std::unique_ptr<SSL, Freed<SSL_free>>;

// A self-signed certificate for localhost, valid for an hour.
TlsFiles WriteCertificate(const std::filesystem::path& folder) {
  Key key(EVP_EC_gen("P-256"));
  Certificate certificate(X509_new());
  X509_set_version(certificate.get(), 2);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate.get()), 1);
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -60);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), 3600);
  X509_NAME* name = X509_get_subject_name(certificate.get());
  X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>("localhost"), -1, -1, 0);
  X509_set_issuer_name(certificate.get(), name);
  X509_set_pubkey(certificate.get(), key.get());
  X509_sign(certificate.get(), key.get(), EVP_sha256());
  TlsFiles files{folder / "certificate.pem", folder / "key.pem"};
  File certificate_file(std::fopen(files.certificate_chain.c_str(), "w"));
  PEM_write_X509(certificate_file.get(), certificate.get());
  File key_file(std::fopen(files.private_key.c_str(), "w"));
  PEM_write_PrivateKey(key_file.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  return files;
}

// One request over TLS of at most `version`; everything the server sends until it closes, or empty.
std::string Exchange(uint16_t port, int version, const std::string& request) {
  int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  timeval limit{20, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string out;
  Context context(SSL_CTX_new(TLS_client_method()));
  SSL_CTX_set_max_proto_version(context.get(), version);
  Tls tls(SSL_new(context.get()));
  SSL_set_fd(tls.get(), socket);
  if (::connect(socket, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0 &&
      SSL_connect(tls.get()) == 1) {
    SSL_write(tls.get(), request.data(), static_cast<int>(request.size()));
    char chunk[4096];
    for (int got; (got = SSL_read(tls.get(), chunk, sizeof(chunk))) > 0;) {
      out.append(chunk, static_cast<size_t>(got));
    }
  }
  ::close(socket);
  return out;
}

// Of the certificate that the server shows now.
Sha256 FingerprintAt(uint16_t port) {
  int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  Context context(SSL_CTX_new(TLS_client_method()));
  Tls tls(SSL_new(context.get()));
  SSL_set_fd(tls.get(), socket);
  Sha256 out;
  unsigned size = 0;
  if (::connect(socket, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0 &&
      SSL_connect(tls.get()) == 1) {
    Certificate found(SSL_get1_peer_certificate(tls.get()));
    X509_digest(found.get(), EVP_sha256(), out.bytes.data(), &size);
  }
  ::close(socket);
  EXPECT_EQ(size, out.bytes.size());
  return out;
}

class TlsTest : public testing::Test {
 protected:
  TlsTest() { options_.tls = WriteCertificate(folder_.path()); }

  test::TempFolder folder_;
  School school_;
  HttpOptions options_;
};

TEST_F(TlsTest, SignInOverTlsSetsAHostCookieAndHsts) {
  RunningServer server(school_, options_);
  const std::string body = std::string(R"({"login":"sam","password":")") + kPassword + R"("})";
  std::string answer =
      Exchange(server.port(), TLS1_3_VERSION,
               "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nOrigin: https://localhost\r\n"
               "Connection: close\r\nContent-Type: application/json\r\nContent-Length: " +
                   std::to_string(body.size()) + "\r\n\r\n" + body);
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 200")) << answer;
  EXPECT_NE(answer.find("Set-Cookie: __Host-enamel_session="), std::string::npos) << answer;
  EXPECT_NE(answer.find("SameSite=Strict; Secure\r\n"), std::string::npos) << answer;
  EXPECT_NE(answer.find("Strict-Transport-Security: max-age=31536000"), std::string::npos);
}

TEST_F(TlsTest, OlderTlsAndPlainHttpGetNoAnswer) {
  RunningServer server(school_, options_);
  const std::string request =
      "GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
  EXPECT_EQ(Exchange(server.port(), TLS1_2_VERSION, request), "");
  EXPECT_NE(Exchange(server.port(), TLS1_3_VERSION, request), "");
  RawClient plain(server.port());
  plain.Send(request);
  auto answer = plain.Read();
  EXPECT_FALSE(answer && answer->status == 200);
}

TEST_F(TlsTest, ASilentPeerIsClosedAtTheHandshakeDeadline) {
  options_.deadlines.handshake = std::chrono::milliseconds(100);
  RunningServer server(school_, options_);
  RawClient silent(server.port());
  EXPECT_TRUE(silent.ClosedByServer());
}

// As a program that renews certificates replaces them.
TEST_F(TlsTest, ACertificateThatWasReplacedIsTakenAndOneThatCannotBeUsedIsNot) {
  options_.certificates = std::chrono::milliseconds(5);
  RunningServer server(school_, options_);
  const Sha256 first = FingerprintAt(server.port());
  folder_.Write("key.pem", "no key");
  const test::TempFolder others;
  WriteCertificate(others.path());
  std::filesystem::rename(others.path() / "certificate.pem", folder_.path() / "certificate.pem");
  EXPECT_EQ(FingerprintAt(server.port()), first) << "its key has not come yet";
  std::filesystem::rename(others.path() / "key.pem", folder_.path() / "key.pem");
  EXPECT_TRUE(test::Becomes([&] { return FingerprintAt(server.port()) != first; }));
}

TEST_F(TlsTest, SaysWhichFileIsMissingOrWrong) {
  boost::asio::io_context io;
  options_.tls->certificate_chain = folder_.path() / "none.pem";
  HttpServer none(io, options_, *school_.store, *school_.authenticator);
  Result<uint16_t> started = none.Start();
  ASSERT_FALSE(started.ok());
  EXPECT_NE(started.status().message().find("none.pem"), std::string::npos);
  options_.tls = WriteCertificate(folder_.path());
  folder_.Write("key.pem", "no key");
  HttpServer wrong(io, options_, *school_.store, *school_.authenticator);
  EXPECT_NE(wrong.Start().status().message().find("key.pem"), std::string::npos);
}

TEST_F(TlsTest, BeyondLoopbackTheHostNamesMustBeNamed) {
  boost::asio::io_context io;
  options_.address = "0.0.0.0";
  HttpServer server(io, options_, *school_.store, *school_.authenticator);
  EXPECT_EQ(server.Start().status().field(), "host_names");
}

}  // namespace
}  // namespace enamel::server::http
