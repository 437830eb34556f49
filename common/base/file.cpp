#include "common/base/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <functional>
#include <string>

#include "common/base/fd.h"

namespace enamel {
namespace {

Status Errno(const std::string& what, const std::filesystem::path& path) {
  Code code = errno == ENOENT ? Code::kNotFound : Code::kStorage;
  return Status(code, what + " " + path.string() + ": " + std::strerror(errno));
}

Status WriteAll(int file, const std::filesystem::path& path, ByteView data) {
  while (!data.empty()) {
    ssize_t n = ::write(file, data.data(), data.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Errno("cannot write", path);
    data = data.subspan(static_cast<size_t>(n));
  }
  return Status::Ok();
}

// `write` gets the descriptor of a temporary file, which then takes the place of `path`.
Status Replace(const std::filesystem::path& path, int mode,
               const std::function<Status(int)>& write) {
  // Process and count are in the name, so that two writers of one path do not write into each
  // other's temporary file: the later rename wins, whole.
  static std::atomic<uint64_t> made{0};
  // A rename would put a file in the place of a device: whoever may write to /dev would be without
  // /dev/null.
  std::error_code unknown;
  if (std::filesystem::is_other(std::filesystem::status(path, unknown))) {
    return Status(Code::kInvalidInput, "cannot write " + path.string() +
                                           ": expected a file or a new name, found something else");
  }
  std::filesystem::path temporary = path;
  temporary += ".tmp" + std::to_string(::getpid()) + "-" + std::to_string(++made);
  {
    Fd fd(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode));
    if (fd.get() < 0) return Errno("cannot create", temporary);
    Status status = write(fd.get());
    // Before the rename. The other way round a power cut may find the new name on disk and its
    // content not.
    if (status.ok() && ::fsync(fd.get()) != 0) status = Errno("cannot sync", temporary);
    if (!status.ok()) {
      ::unlink(temporary.c_str());
      return status;
    }
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    Status status = Errno("cannot rename to", path);
    ::unlink(temporary.c_str());
    return status;
  }
  // The new name is on disk only when its folder is (fsync(2)). An error from here on says that a
  // power cut may still bring the old content back; readers see the new one already.
  Fd folder(::open(path.parent_path().empty() ? "." : path.parent_path().c_str(),
                   O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.get() < 0) return Errno("cannot open the folder of", path);
  if (::fsync(folder.get()) != 0) return Errno("cannot sync the folder of", path);
  return Status::Ok();
}

}  // namespace

Result<Bytes> ReadFile(const std::filesystem::path& path, size_t max_bytes) {
  Fd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) return Errno("cannot open", path);
  struct stat info {};
  if (::fstat(fd.get(), &info) != 0) return Errno("cannot stat", path);
  if (S_ISDIR(info.st_mode)) {
    return Status(Code::kInvalidInput, path.string() + " is a folder, expected a file");
  }
  Bytes out;
  // A hint only: /proc gives 0, and a file may grow while it is read. Only read finds the end.
  out.reserve(static_cast<size_t>(info.st_size > 0 ? info.st_size : 0));
  uint8_t buffer[65536];
  for (;;) {
    ssize_t n = ::read(fd.get(), buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Errno("cannot read", path);
    if (n == 0) return out;
    if (out.size() + static_cast<size_t>(n) > max_bytes) {
      return Status(Code::kTooLarge, path.string() + " is larger than the " +
                                         std::to_string(max_bytes) + " bytes allowed here");
    }
    out.insert(out.end(), buffer, buffer + n);
  }
}

Status WriteFileDurably(const std::filesystem::path& path, ByteView data, int mode) {
  return Replace(path, mode, [&](int file) { return WriteAll(file, path, data); });
}

Status WriteFileDurably(const std::filesystem::path& path, const BytePieces& content, int mode) {
  return Replace(path, mode, [&](int file) -> Status {
    for (;;) {
      ENAMEL_ASSIGN_OR_RETURN(const Bytes piece, content.next());
      if (piece.empty()) return Status::Ok();
      ENAMEL_RETURN_IF_ERROR(WriteAll(file, path, piece));
    }
  });
}

std::filesystem::path OwnFolder() {
  std::error_code error;
  auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  return error ? std::filesystem::path(".") : self.parent_path();
}

}  // namespace enamel
