#include "server/storage/folder/ticket_key.h"

#include <algorithm>

#include "common/base/file.h"

namespace enamel::server {

std::filesystem::path TicketKeyPath(const std::filesystem::path& folder) {
  return folder / "ticket.key";
}

Result<trace::KeyPair> ReadTicketKey(const std::filesystem::path& folder) {
  const std::filesystem::path path = TicketKeyPath(folder);
  trace::KeyPair keys{};
  ENAMEL_ASSIGN_OR_RETURN(auto stored, ReadFile(path, 1024));
  if (stored.size() != keys.secret_key.size()) {
    return Status(Code::kInvalidInput, path.string() + " has " + std::to_string(stored.size()) +
                                           " bytes, a ticket key has 64; restore it from a backup");
  }
  std::ranges::copy(stored, keys.secret_key.begin());
  std::copy(stored.end() - 32, stored.end(), keys.public_key.begin());
  return keys;
}

Result<trace::KeyPair> EnsureTicketKey(const std::filesystem::path& folder, Disk& disk) {
  auto stored = ReadTicketKey(folder);
  if (stored.ok() || stored.status().code() != Code::kNotFound) return stored;
  const trace::KeyPair keys = trace::NewKeyPair();
  ENAMEL_RETURN_IF_ERROR(disk.Replace(TicketKeyPath(folder), keys.secret_key));
  return keys;
}

}  // namespace enamel::server
