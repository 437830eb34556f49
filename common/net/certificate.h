#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"

struct evp_pkey_st;
struct x509_st;

// Identity of a server on the station link: a self-signed certificate known by its fingerprint,
// which a station gets when it enrols. No certificate authority is needed or consulted.
namespace enamel::net {

struct CertificatePem {
  std::string certificate;
  std::string private_key;  // PKCS #8, not encrypted
};

// EC P-256, valid from one day ago (clocks differ) for ten years, subject CN = `common_name` (1 to
// 64 characters), alternative names `common_name`, localhost and 127.0.0.1. Errors: kInvalidInput,
// kInternal (OpenSSL).
Result<CertificatePem> MakeSelfSignedCertificate(const std::string& common_name);

// Makes a certificate and writes it (mode 0644) and its key (mode 0600) as PEM files, key first.
// Errors: kConflict if either exists (nothing is overwritten: stations know the old one), kStorage.
Status CreateCertificateFiles(const std::filesystem::path& certificate,
                              const std::filesystem::path& private_key,
                              const std::string& common_name);

// SHA-256 of the certificate's DER form, what `openssl x509 -fingerprint -sha256` prints. With more
// than one certificate in the text: of the first. Errors: kInvalidInput.
Result<Sha256> CertificateFingerprint(ByteView pem);

// When the first certificate of the text begins and ends, Unix time in milliseconds. Errors:
// kInvalidInput.
struct CertificateTime {
  int64_t from_ms = 0, until_ms = 0;
};
Result<CertificateTime> CertificateTimeOf(ByteView pem);
// Where each certificate of the text is not signed by the next one: which is out of order, and what
// to do. Clients that do not sort them refuse the first. Empty: they are in order, or there is one.
std::string ChainProblem(ByteView pem);
// Number of the certificate that the key belongs to: 1 is the first, 0 none.
size_t CertificateOfKey(ByteView pem, const evp_pkey_st* key);
int64_t EndOfCertificateMs(const x509_st* certificate);

}  // namespace enamel::net
