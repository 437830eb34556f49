#include "server/app/data_folder.h"

#include <algorithm>

#include "common/base/file.h"
#include "common/net/certificate.h"
#include "server/storage/sqlite_store.h"

namespace enamel::server::app {
namespace {

Result<trace::KeyPair> EnsureTicketKey(const std::filesystem::path& path) {
  trace::KeyPair keys{};
  auto stored = ReadFile(path, 1024);
  if (!stored.ok() && stored.status().code() == Code::kNotFound) {
    keys = trace::NewKeyPair();
    ENAMEL_RETURN_IF_ERROR(WriteFileDurably(path, keys.secret_key, 0600));
    return keys;
  }
  if (!stored.ok()) return stored.status();
  if (stored->size() != keys.secret_key.size()) {
    return Status(Code::kInvalidInput, path.string() + " has " + std::to_string(stored->size()) +
                                           " bytes, a ticket key has 64; restore it from a backup");
  }
  std::ranges::copy(*stored, keys.secret_key.begin());
  // libsodium's secret key ends with the public one.
  std::copy(stored->end() - 32, stored->end(), keys.public_key.begin());
  return keys;
}

Status EnsureCertificate(const ServerIdentity& identity) {
  std::error_code error;
  if (std::filesystem::exists(identity.certificate, error)) return Status::Ok();
  Status made =
      net::CreateCertificateFiles(identity.certificate, identity.private_key, "enamel-server");
  // Another command of ours was faster.
  if (made.code() == Code::kConflict && std::filesystem::exists(identity.certificate, error)) {
    return Status::Ok();
  }
  return made;
}

}  // namespace

Result<ServerIdentity> EnsureIdentity(const std::filesystem::path& folder) {
  ServerIdentity identity;
  identity.certificate = folder / "station.crt";
  identity.private_key = folder / "station.key";
  ENAMEL_RETURN_IF_ERROR(EnsureCertificate(identity));
  auto pem = ReadFile(identity.certificate, 1 << 20);
  if (!pem.ok()) return pem.status();
  auto fingerprint = net::CertificateFingerprint(*pem);
  if (!fingerprint.ok()) return fingerprint.status();
  identity.fingerprint = *fingerprint;
  auto keys = EnsureTicketKey(folder / "ticket.key");
  if (!keys.ok()) return keys.status();
  identity.ticket_key = *keys;
  return identity;
}

Result<std::unique_ptr<Store>> OpenForCommand(const std::filesystem::path& folder) {
  SqliteOptions options;
  options.folder = folder;
  return OpenSqliteStore(options);
}

}  // namespace enamel::server::app
