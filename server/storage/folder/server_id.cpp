#include "server/storage/folder/server_id.h"

#include "common/base/file.h"

namespace enamel::server {

Result<Uuid> EnsureServerId(const std::filesystem::path& folder, Disk& disk) {
  const std::filesystem::path path = folder / "server.id";
  auto stored = ReadFile(path, 1024);
  if (stored.ok()) {
    std::string text(AsText(*stored));
    while (!text.empty() && text.back() == '\n') text.pop_back();
    auto id = Uuid::Parse(text);
    if (id.ok() && !id->IsZero()) return id;
    return Status(Code::kInvalidInput,
                  path.string() + ": expected a UUID, found \"" + text.substr(0, 60) +
                      "\"; take the file away, and the server gives itself a new one");
  }
  if (stored.status().code() != Code::kNotFound) return stored.status();
  const Uuid id = Uuid::New();
  ENAMEL_RETURN_IF_ERROR(disk.Replace(path, AsBytes(id.Text() + "\n")));
  return id;
}

}  // namespace enamel::server
