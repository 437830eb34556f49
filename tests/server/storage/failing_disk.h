#pragma once

#include <filesystem>
#include <functional>

#include "server/storage/folder/disk.h"

namespace enamel::server::testing {

// The machine's disk, whose n-th change fails.
class FailingDisk final : public Disk {
 public:
  int until_failure = -1;  // -1: never
  bool fired = false;
  std::function<void()> before_change;

  Status Replace(const std::filesystem::path& path, ByteView data) override {
    return Fails() ? No() : SystemDisk().Replace(path, data);
  }
  Status MakeFolder(const std::filesystem::path& path) override {
    return Fails() ? No() : SystemDisk().MakeFolder(path);
  }
  Status SyncFolder(const std::filesystem::path& path) override {
    return Fails() ? No() : SystemDisk().SyncFolder(path);
  }
  Status Remove(const std::filesystem::path& path) override {
    return Fails() ? No() : SystemDisk().Remove(path);
  }
  Status Shred(const std::filesystem::path& path) override {
    return Fails() ? No() : SystemDisk().Shred(path);
  }
  Result<Content> Hash(const std::filesystem::path& path) override {
    return SystemDisk().Hash(path);
  }
  Result<Copied> Copy(const std::filesystem::path& from, const std::filesystem::path& to,
                      bool link) override {
    if (Fails()) return No();
    return SystemDisk().Copy(from, to, link);
  }
  Status SyncAll(const std::filesystem::path& folder) override {
    return Fails() ? No() : SystemDisk().SyncAll(folder);
  }
  Result<uint64_t> FreeBytes(const std::filesystem::path& folder) override {
    return SystemDisk().FreeBytes(folder);
  }

 private:
  bool Fails() {
    if (before_change) before_change();
    if (until_failure < 0 || until_failure-- > 0) return false;
    fired = true;
    return true;
  }
  static Status No() { return Status(Code::kStorage, "no space left on device"); }
};

}  // namespace enamel::server::testing
