#include "server/storage/folder/disk.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <optional>

#include "common/base/fd.h"
#include "common/base/file.h"

namespace enamel::server {
namespace {

namespace fs = std::filesystem;

Status Failed(const char* what, const fs::path& path, int error) {
  std::string message = std::string(what) + " " + path.string() + ": " + std::strerror(error);
  if (error == ENOSPC || error == EDQUOT) message += "; free some disk space";
  if (error == EACCES || error == EPERM || error == EROFS)
    message += "; make the folder writable for this user";
  return Status(Code::kStorage, message);
}

// Zeros once: only the drive can promise more for the medium below the file system.
Status Overwrite(int fd, const fs::path& path) {
  struct stat info {};
  if (::fstat(fd, &info) != 0) return Failed("cannot stat", path, errno);
  const Bytes zeros(4096, 0);
  for (off_t at = 0; at < info.st_size;) {
    size_t want = std::min(zeros.size(), static_cast<size_t>(info.st_size - at));
    ssize_t n = ::pwrite(fd, zeros.data(), want, at);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Failed("cannot overwrite", path, errno);
    at += n;
  }
  if (::fsync(fd) != 0) return Failed("cannot sync", path, errno);
  return Status::Ok();
}

Status WriteAll(int fd, ByteView data, const fs::path& path) {
  while (!data.empty()) {
    ssize_t n = ::write(fd, data.data(), data.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Failed("cannot write", path, errno);
    data = data.subspan(static_cast<size_t>(n));
  }
  return Status::Ok();
}

// Hands the file's content on, piece by piece; at least one, which may be empty.
Result<Disk::Content> Read(const fs::path& path, const std::function<Status(ByteView)>& take) {
  auto unreadable = [&](const char* what) {
    return Status(Code::kNotFound, Failed(what, path, errno).message());
  };
  Fd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) return unreadable("cannot open");
  Disk::Content out;
  Sha256Stream hash;
  Bytes buffer(1 << 20);
  for (;;) {
    ssize_t n = ::read(fd.get(), buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return unreadable("cannot read");
    ByteView part = ByteView(buffer).first(static_cast<size_t>(n));
    if (n > 0 || out.bytes == 0) ENAMEL_RETURN_IF_ERROR(take(part));
    if (n == 0) break;
    hash.Update(part);
    out.bytes += part.size();
  }
  out.hash = hash.Finish();
  return out;
}

class PosixDisk final : public Disk {
 public:
  Status Replace(const fs::path& path, ByteView data) override {
    return WriteFileDurably(path, data, 0600);
  }

  Status MakeFolder(const fs::path& path) override {
    std::error_code error;
    if (path.empty() || fs::is_directory(path, error)) return Status::Ok();
    ENAMEL_RETURN_IF_ERROR(MakeFolder(path.parent_path()));
    if (::mkdir(path.c_str(), 0700) != 0 && errno != EEXIST)
      return Failed("cannot make the folder", path, errno);
    return SyncFolder(path.parent_path());
  }

  Status SyncFolder(const fs::path& path) override {
    Fd fd(::open(path.empty() ? "." : path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (fd.get() < 0) return Failed("cannot open the folder", path, errno);
    if (::fsync(fd.get()) != 0) return Failed("cannot sync the folder", path, errno);
    return Status::Ok();
  }

  Status Remove(const fs::path& path) override {
    if (::unlink(path.c_str()) != 0) {
      return errno == ENOENT ? Status::Ok() : Failed("cannot remove", path, errno);
    }
    return SyncFolder(path.parent_path());
  }

  Status Shred(const fs::path& path) override {
    {
      Fd fd(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
      if (fd.get() < 0) {
        return errno == ENOENT ? Status::Ok() : Failed("cannot open", path, errno);
      }
      ENAMEL_RETURN_IF_ERROR(Overwrite(fd.get(), path));
    }
    return Remove(path);
  }

  Result<Content> Hash(const fs::path& path) override {
    return Read(path, [](ByteView) { return Status::Ok(); });
  }

  Result<Copied> Copy(const fs::path& from, const fs::path& to, bool link) override {
    Copied out;
    std::error_code error;
    // Where that fails (another file system) it is copied. A link to a blob is safe: blobs are
    // never changed in their place.
    if (link) fs::create_hard_link(from, to, error);
    out.linked = link && !error;
    std::optional<Fd> target;
    auto content = Read(from, [&](ByteView part) -> Status {
      if (out.linked) return Status::Ok();
      if (!target)
        target.emplace(::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
      if (target->get() < 0) return Failed("cannot create", to, errno);
      return WriteAll(target->get(), part, to);
    });
    ENAMEL_RETURN_IF_ERROR(content.status());
    static_cast<Content&>(out) = *content;
    return out;
  }

  Status SyncAll(const fs::path& folder) override {
    Fd fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (fd.get() < 0) return Failed("cannot open the folder", folder, errno);
    if (::syncfs(fd.get()) != 0) return Failed("cannot sync", folder, errno);
    return Status::Ok();
  }

  Result<uint64_t> FreeBytes(const fs::path& folder) override {
    struct statvfs info {};
    if (::statvfs(folder.c_str(), &info) != 0)
      return Failed("cannot read the free space of", folder, errno);
    // f_bavail, not f_bfree: the last blocks are root's.
    return uint64_t{info.f_bavail} * info.f_frsize;
  }
};

}  // namespace

Disk& SystemDisk() {
  static PosixDisk disk;
  return disk;
}

}  // namespace enamel::server
