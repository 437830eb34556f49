#include "server/storage/folder/private_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>

#include "common/base/file.h"

namespace enamel::server {

Result<Bytes> ReadPrivateFile(const std::filesystem::path& path, size_t max_bytes,
                              const std::string& what, const std::string& remedy) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) {
    const int why = errno;
    const bool absent = why == ENOENT && ::lstat(path.c_str(), &info) != 0;
    return Status(absent ? Code::kNotFound : Code::kStorage,
                  "expected " + what + " in " + path.string() + ", found " +
                      (absent ? "no such file; " + remedy : std::strerror(why)) +
                      " (schemas/database.md)");
  }
  if ((info.st_mode & 077) != 0) {
    return Status(Code::kForbidden, "expected " + what +
                                        " in a file that its owner alone may read, found that "
                                        "others may read " +
                                        path.string() + "; chmod 600 it");
  }
  return ReadFile(path, max_bytes);
}

}  // namespace enamel::server
