#include "server/storage/folder/private_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "common/base/fd.h"

namespace enamel::server {

Result<Bytes> ReadPrivateFile(const std::filesystem::path& path, size_t max_bytes,
                              const std::string& what, const std::string& remedy) {
  // Opened first: nobody can replace the file between the check and the reading.
  const Fd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat info {};
  if (file.get() < 0 || ::fstat(file.get(), &info) != 0) {
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
  Bytes out(max_bytes + 1);
  size_t size = 0;
  while (size < out.size()) {
    const ssize_t n = ::read(file.get(), out.data() + size, out.size() - size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      return Status(Code::kStorage, "expected " + what + " in " + path.string() + ", found " +
                                        std::strerror(errno));
    }
    if (n == 0) break;
    size += static_cast<size_t>(n);
  }
  if (size > max_bytes) {
    return Status(Code::kTooLarge, "expected at most " + std::to_string(max_bytes) + " bytes in " +
                                       path.string() + ", found more");
  }
  out.resize(size);
  return out;
}

}  // namespace enamel::server
