#include "common/net/certificate.h"

#include <arpa/inet.h>
#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <cctype>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "common/base/file.h"

namespace enamel::net {
namespace {

template <auto kFree>
struct Free {
  template <typename T>
  void operator()(T* p) const {
    kFree(p);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Bio = std::unique_ptr<BIO, Free<BIO_free_all>>;
using Extension = std::unique_ptr<X509_EXTENSION, Free<X509_EXTENSION_free>>;

constexpr long kDay_s = 24 * 3600;
// Ten years: a new one means telling every station (schemas/wire/README.md, "Transport").
constexpr long kValid_s = 3652 * kDay_s;
constexpr size_t kMaxCommonName = 64;

Status OpenSslFailed(const char* what) {
  char text[256] = "no detail";
  if (unsigned long code = ERR_get_error()) ERR_error_string_n(code, text, sizeof text);
  // The queue is the thread's: the next failure would report what stays in it.
  ERR_clear_error();
  return Status(Code::kInternal, std::string("OpenSSL could not ") + what + ": " + text);
}

// Letters, digits, '.', '-' and '_': nothing that could change the meaning of an extension's text.
bool IsHostName(const std::string& name) {
  return !name.empty() && name.size() <= kMaxCommonName &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return (c < 0x80 && std::isalnum(c)) || c == '.' || c == '-' || c == '_';
         });
}

// Browsers look for an address among the addresses only.
std::string AlternativeName(const std::string& name) {
  in_addr address{};
  return (inet_pton(AF_INET, name.c_str(), &address) == 1 ? "IP:" : "DNS:") + name;
}

bool AddExtension(X509* certificate, int nid, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
  Extension extension(X509V3_EXT_conf_nid(nullptr, &context, nid, value.c_str()));
  return extension && X509_add_ext(certificate, extension.get(), -1) == 1;
}

bool SetSerial(X509* certificate) {
  uint64_t serial = 0;
  if (RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) != 1) return false;
  return ASN1_INTEGER_set_uint64(X509_get_serialNumber(certificate), serial >> 1) == 1;
}

bool SetSubject(X509* certificate, const std::string& common_name) {
  X509_NAME* name = X509_get_subject_name(certificate);
  const auto* text = reinterpret_cast<const unsigned char*>(common_name.c_str());
  return X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8, text, -1, -1, 0) == 1 &&
         X509_set_issuer_name(certificate, name) == 1;
}

Certificate SignFor(EVP_PKEY* key, const std::string& common_name) {
  Certificate certificate(X509_new());
  X509* c = certificate.get();
  bool made = c && X509_set_version(c, X509_VERSION_3) == 1 && SetSerial(c) &&
              X509_gmtime_adj(X509_getm_notBefore(c), -kDay_s) &&
              X509_gmtime_adj(X509_getm_notAfter(c), kValid_s) && SetSubject(c, common_name) &&
              X509_set_pubkey(c, key) == 1 &&
              AddExtension(c, NID_basic_constraints, "critical,CA:FALSE") &&
              AddExtension(c, NID_ext_key_usage, "serverAuth") &&
              AddExtension(c, NID_subject_alt_name,
                           AlternativeName(common_name) + ",DNS:localhost,IP:127.0.0.1") &&
              X509_sign(c, key, EVP_sha256()) > 0;
  return made ? std::move(certificate) : nullptr;
}

std::string TextOf(BIO* bio) {
  char* data = nullptr;
  long size = BIO_get_mem_data(bio, &data);
  return std::string(data, static_cast<size_t>(size));
}

Status CheckAbsent(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return Status::Ok();
  return Status(Code::kConflict,
                path.string() +
                    " exists and is not overwritten, because enrolled stations know it; "
                    "move it away to make a new one and enrol the stations again");
}

}  // namespace

Result<CertificatePem> MakeSelfSignedCertificate(const std::string& common_name) {
  if (!IsHostName(common_name)) {
    return Status(Code::kInvalidInput,
                  "certificate name: expected 1 to 64 letters, digits, '.', '-' or '_', found \"" +
                      common_name.substr(0, 80) + "\"",
                  "common_name");
  }
  Key key(EVP_EC_gen("P-256"));
  if (!key) return OpenSslFailed("make a key");
  Certificate certificate = SignFor(key.get(), common_name);
  if (!certificate) return OpenSslFailed("make a certificate");
  Bio certificate_out(BIO_new(BIO_s_mem())), key_out(BIO_new(BIO_s_secmem()));
  if (!certificate_out || !key_out ||
      PEM_write_bio_X509(certificate_out.get(), certificate.get()) != 1 ||
      PEM_write_bio_PKCS8PrivateKey(key_out.get(), key.get(), nullptr, nullptr, 0, nullptr,
                                    nullptr) != 1) {
    return OpenSslFailed("write a certificate");
  }
  return CertificatePem{TextOf(certificate_out.get()), TextOf(key_out.get())};
}

Status CreateCertificateFiles(const std::filesystem::path& certificate,
                              const std::filesystem::path& private_key,
                              const std::string& common_name) {
  ENAMEL_RETURN_IF_ERROR(CheckAbsent(certificate));
  ENAMEL_RETURN_IF_ERROR(CheckAbsent(private_key));
  ENAMEL_ASSIGN_OR_RETURN(auto pem, MakeSelfSignedCertificate(common_name));
  // Broken off here, there is a key that no station knows of. The other way round a certificate
  // without its key could be handed out.
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(private_key, AsBytes(pem.private_key), 0600));
  return WriteFileDurably(certificate, AsBytes(pem.certificate), 0644);
}

namespace {

Result<Certificate> FirstOf(ByteView pem) {
  Bio in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  Certificate certificate(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr));
  ERR_clear_error();
  if (certificate) return certificate;
  return Status(Code::kInvalidInput,
                "expected a certificate in PEM form (-----BEGIN CERTIFICATE-----), "
                "found none that can be read");
}

}  // namespace

Result<Sha256> CertificateFingerprint(ByteView pem) {
  ENAMEL_ASSIGN_OR_RETURN(const Certificate certificate, FirstOf(pem));
  Sha256 out;
  unsigned int size = 0;
  if (X509_digest(certificate.get(), EVP_sha256(), out.bytes.data(), &size) != 1 ||
      size != out.bytes.size()) {
    return OpenSslFailed("hash a certificate");
  }
  return out;
}

namespace {

int64_t MsOf(const ASN1_TIME* time) {
  std::tm moment{};
  return ASN1_TIME_to_tm(time, &moment) == 1 ? int64_t{timegm(&moment)} * 1000 : 0;
}

std::vector<Certificate> AllOf(ByteView pem) {
  constexpr size_t kMost = 100;
  Bio in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  std::vector<Certificate> out;
  while (out.size() < kMost) {
    Certificate next(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr));
    if (!next) break;
    out.push_back(std::move(next));
  }
  ERR_clear_error();
  return out;
}

std::string SubjectOf(const X509* certificate) {
  Bio out(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(out.get(), X509_get_subject_name(certificate), 0, XN_FLAG_ONELINE);
  return "\"" + TextOf(out.get()) + "\"";
}

}  // namespace

Result<CertificateTime> CertificateTimeOf(ByteView pem) {
  ENAMEL_ASSIGN_OR_RETURN(const Certificate certificate, FirstOf(pem));
  return CertificateTime{MsOf(X509_get0_notBefore(certificate.get())),
                         EndOfCertificateMs(certificate.get())};
}

int64_t EndOfCertificateMs(const X509* certificate) {
  return MsOf(X509_get0_notAfter(certificate));
}

std::string ChainProblem(ByteView pem) {
  const auto all = AllOf(pem);
  for (size_t i = 1; i < all.size(); ++i) {
    if (X509_check_issued(all[i].get(), all[i - 1].get()) == X509_V_OK) continue;
    return "certificate " + std::to_string(i + 1) + ", " + SubjectOf(all[i].get()) +
           ", did not sign certificate " + std::to_string(i) + ", " + SubjectOf(all[i - 1].get()) +
           "; put each signer's certificate after the one that it signed";
  }
  return {};
}

size_t CertificateOfKey(ByteView pem, const EVP_PKEY* key) {
  const auto all = AllOf(pem);
  const auto at = std::ranges::find_if(all, [&](const Certificate& one) {
    return EVP_PKEY_eq(X509_get0_pubkey(one.get()), key) == 1;
  });
  ERR_clear_error();
  return at == all.end() ? 0 : static_cast<size_t>(at - all.begin()) + 1;
}

}  // namespace enamel::net
