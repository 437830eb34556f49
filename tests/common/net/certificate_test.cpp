#include "common/net/certificate.h"

#include <gtest/gtest.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/ssl/context.hpp>
#include <ctime>

#include "common/base/file.h"
#include "common/net/tls.h"
#include "tests/support/temp_folder.h"

namespace enamel::net {
namespace {

class CertificateTest : public testing::Test {
 protected:
  std::filesystem::path certificate() const { return folder_ / "station.crt"; }
  std::filesystem::path key() const { return folder_ / "station.key"; }

  test::TempFolder temp_;
  const std::filesystem::path folder_ = temp_.path();
};

X509* Parse(const std::string& pem) {
  BIO* bio = BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size()));
  X509* out = PEM_read_bio_X509(bio, nullptr, nullptr, nullptr);
  BIO_free(bio);
  return out;
}

TEST_F(CertificateTest, IsAnEcCertificateForTenYearsSignedByItself) {
  auto pem = MakeSelfSignedCertificate("enamel.example");
  ASSERT_TRUE(pem.ok()) << pem.status().message();
  X509* x = Parse(pem->certificate);
  ASSERT_NE(x, nullptr);
  EVP_PKEY* key = X509_get0_pubkey(x);
  EXPECT_EQ(EVP_PKEY_get_base_id(key), EVP_PKEY_EC);
  EXPECT_EQ(EVP_PKEY_get_bits(key), 256);
  EXPECT_EQ(X509_verify(x, key), 1);
  time_t in_nine_years = std::time(nullptr) + 9 * 365 * 86400L;
  time_t in_eleven_years = std::time(nullptr) + 11 * 365 * 86400L;
  EXPECT_LT(X509_cmp_current_time(X509_get0_notBefore(x)), 0);
  EXPECT_GT(X509_cmp_time(X509_get0_notAfter(x), &in_nine_years), 0);
  EXPECT_LT(X509_cmp_time(X509_get0_notAfter(x), &in_eleven_years), 0);
  EXPECT_EQ(X509_check_host(x, "enamel.example", 0, 0, nullptr), 1);
  EXPECT_EQ(X509_check_ip_asc(x, "127.0.0.1", 0), 1);
  X509_free(x);
}

TEST_F(CertificateTest, FingerprintIsTheDigestOfTheDerForm) {
  auto pem = MakeSelfSignedCertificate("enamel.example");
  X509* x = Parse(pem->certificate);
  unsigned char* der = nullptr;
  int size = i2d_X509(x, &der);
  ASSERT_GT(size, 0);
  EXPECT_EQ(*CertificateFingerprint(AsBytes(pem->certificate)),
            HashSha256({der, static_cast<size_t>(size)}));
  OPENSSL_free(der);
  X509_free(x);
}

TEST_F(CertificateTest, EachOneIsNew) {
  auto a = MakeSelfSignedCertificate("a"), b = MakeSelfSignedCertificate("a");
  EXPECT_NE(*CertificateFingerprint(AsBytes(a->certificate)),
            *CertificateFingerprint(AsBytes(b->certificate)));
}

TEST_F(CertificateTest, NameThatCouldChangeTheCertificateIsRefused) {
  for (const char* name : {"", "a,DNS:other", "a b", "a\nb", "\xc3\xa4"}) {
    EXPECT_EQ(MakeSelfSignedCertificate(name).status().code(), Code::kInvalidInput) << name;
  }
  EXPECT_FALSE(MakeSelfSignedCertificate(std::string(65, 'a')).ok());
}

TEST_F(CertificateTest, KeyFileIsReadableByItsOwnerOnly) {
  ASSERT_TRUE(CreateCertificateFiles(certificate(), key(), "a").ok());
  struct stat info {};
  ASSERT_EQ(::stat(key().c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
}

TEST_F(CertificateTest, ExistingFilesAreNeverOverwritten) {
  ASSERT_TRUE(CreateCertificateFiles(certificate(), key(), "a").ok());
  Bytes before = *ReadFile(certificate());
  EXPECT_EQ(CreateCertificateFiles(certificate(), key(), "a").code(), Code::kConflict);
  std::filesystem::remove(certificate());
  EXPECT_EQ(CreateCertificateFiles(certificate(), key(), "a").code(), Code::kConflict);
  EXPECT_FALSE(std::filesystem::exists(certificate()));
}

TEST_F(CertificateTest, ServerContextTakesTheFiles) {
  ASSERT_TRUE(CreateCertificateFiles(certificate(), key(), "a").ok());
  auto context = MakeServerContext(certificate(), key());
  ASSERT_TRUE(context.ok()) << context.status().message();
  EXPECT_EQ(SSL_CTX_get_min_proto_version(context->get()), TLS1_3_VERSION);
}

TEST_F(CertificateTest, ServerContextNamesTheFileItCannotUse) {
  EXPECT_EQ(MakeServerContext(certificate(), key()).status().code(), Code::kNotFound);
  ASSERT_TRUE(CreateCertificateFiles(certificate(), key(), "a").ok());
  auto other = MakeSelfSignedCertificate("b");
  ASSERT_TRUE(WriteFileDurably(key(), AsBytes(other->private_key), 0600).ok());
  auto context = MakeServerContext(certificate(), key());
  EXPECT_EQ(context.status().code(), Code::kInvalidInput);
  EXPECT_NE(context.status().message().find("station.key"), std::string::npos)
      << context.status().message();
}

TEST_F(CertificateTest, AChainThatDoesNotBeginWithTheKeysCertificateIsNamed) {
  ASSERT_TRUE(CreateCertificateFiles(certificate(), key(), "a").ok());
  const std::string own(AsText(*ReadFile(certificate())));
  const std::string other = MakeSelfSignedCertificate("b")->certificate;
  std::filesystem::remove(certificate());
  ASSERT_TRUE(WriteFileDurably(certificate(), AsBytes(other + own), 0644).ok());
  const std::string why = MakeServerContext(certificate(), key()).status().message();
  EXPECT_TRUE(why.starts_with(certificate().string() + ": expected the certificate of ")) << why;
  EXPECT_NE(why.find("wrong order"), std::string::npos) << why;
  EXPECT_EQ(ChainProblem(AsBytes(own)), "");
  const std::string problem = ChainProblem(AsBytes(own + other));
  EXPECT_NE(problem.find("certificate 2, \"CN = b\", did not sign certificate 1"),
            std::string::npos)
      << problem;
}

TEST_F(CertificateTest, AKeyWithAPassphraseIsNamedWithTheWayOut) {
  ASSERT_TRUE(CreateCertificateFiles(certificate(), key(), "a").ok());
  for (const char* encrypted :
       {"-----BEGIN ENCRYPTED PRIVATE KEY-----\nMIIB\n-----END ENCRYPTED PRIVATE KEY-----\n",
        "-----BEGIN EC PRIVATE KEY-----\nProc-Type: 4,ENCRYPTED\n\nMIIB\n"
        "-----END EC PRIVATE KEY-----\n"}) {
    std::filesystem::remove(key());
    ASSERT_TRUE(WriteFileDurably(key(), AsBytes(std::string_view(encrypted)), 0600).ok());
    const std::string why = MakeServerContext(certificate(), key()).status().message();
    EXPECT_TRUE(why.starts_with(key().string() + ": expected a private key that is not encrypted"))
        << why;
    EXPECT_NE(why.find("openssl pkey -in"), std::string::npos) << why;
  }
}

TEST_F(CertificateTest, TextThatIsNoCertificateHasNoFingerprint) {
  EXPECT_EQ(CertificateFingerprint(AsBytes("hello")).status().code(), Code::kInvalidInput);
  EXPECT_EQ(CertificateFingerprint({}).status().code(), Code::kInvalidInput);
}

}  // namespace
}  // namespace enamel::net
