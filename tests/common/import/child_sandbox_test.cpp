#include "common/import/child_sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

// The limits of the confined mesh reader, tried in a child of this test's own.
namespace enamel::import {
namespace {

namespace fs = std::filesystem;

// Of those that the C library has no function for.
template <typename... Arguments>
int Call(long number, Arguments... arguments) {
  return static_cast<int>(syscall(number, arguments...));
}

class SandboxTest : public ::testing::Test {
 protected:
  SandboxTest() {
    fs::create_directories(folder_ / "empty");
    std::ofstream(file_) << "x";
  }
  ~SandboxTest() override { fs::remove_all(folder_); }

  const fs::path folder_ =
      fs::temp_directory_path() / ("enamel_sandbox_" + std::to_string(getpid()));
  const fs::path file_ = folder_ / "file";
};

TEST_F(SandboxTest, NoFileAndNoOtherProcessCanBeReached) {
  const std::string file = file_, other = folder_ / "other", empty = folder_ / "empty";
  const int folder_fd = open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_GE(folder_fd, 0);
  const pid_t parent = getpid();
  const int pidfd = Call(SYS_pidfd_open, parent, 0);
  ASSERT_GE(pidfd, 0);
  char mine = 0;
  const iovec here{&mine, 1}, there{&mine, 1};
  rlimit limit{};
  const std::vector<std::pair<const char*, std::function<int()>>> attempts = {
      {"open", [&] { return open(file.c_str(), O_RDONLY); }},
      {"creat", [&] { return creat(other.c_str(), 0600); }},
      {"unlink", [&] { return unlink(file.c_str()); }},
      {"unlinkat", [&] { return unlinkat(folder_fd, "file", 0); }},
      {"rename", [&] { return rename(file.c_str(), other.c_str()); }},
      {"renameat", [&] { return renameat(folder_fd, "file", folder_fd, "other"); }},
      {"mkdir", [&] { return mkdir(other.c_str(), 0700); }},
      {"mkdirat", [&] { return mkdirat(folder_fd, "other", 0700); }},
      {"rmdir", [&] { return rmdir(empty.c_str()); }},
      {"link", [&] { return link(file.c_str(), other.c_str()); }},
      {"linkat", [&] { return linkat(folder_fd, "file", folder_fd, "other", 0); }},
      {"symlink", [&] { return symlink(file.c_str(), other.c_str()); }},
      {"symlinkat", [&] { return symlinkat("file", folder_fd, "other"); }},
      {"mkfifo", [&] { return mkfifo(other.c_str(), 0600); }},
      {"chmod", [&] { return chmod(file.c_str(), 0); }},
      {"fchmodat", [&] { return fchmodat(folder_fd, "file", 0, 0); }},
      {"fchmod", [&] { return fchmod(folder_fd, 0); }},
      {"chown", [&] { return chown(file.c_str(), getuid(), getgid()); }},
      {"truncate", [&] { return truncate(file.c_str(), 0); }},
      {"utimensat", [&] { return utimensat(folder_fd, "file", nullptr, 0); }},
      {"kill", [&] { return kill(parent, 0); }},
      // Another process: its memory, its descriptors, its limits.
      {"tgkill", [&] { return Call(SYS_tgkill, parent, parent, 0); }},
      {"ptrace", [&] { return static_cast<int>(ptrace(PTRACE_ATTACH, parent, nullptr, nullptr)); }},
      {"process_vm_readv",
       [&] { return static_cast<int>(process_vm_readv(parent, &here, 1, &there, 1, 0)); }},
      {"process_vm_writev",
       [&] { return static_cast<int>(process_vm_writev(parent, &here, 1, &there, 1, 0)); }},
      {"pidfd_open", [&] { return Call(SYS_pidfd_open, parent, 0); }},
      {"pidfd_getfd", [&] { return Call(SYS_pidfd_getfd, pidfd, 0, 0); }},
      {"prlimit64", [&] { return prlimit(parent, RLIMIT_NOFILE, nullptr, &limit); }},
      {"socket", [&] { return socket(AF_INET, SOCK_STREAM, 0); }},
  };
  const pid_t pid = fork();
  ASSERT_GE(pid, 0);
  if (pid == 0) {
    if (!ForbidSystem()) _exit(200);
    for (size_t i = 0; i < attempts.size(); ++i) {
      if (attempts[i].second() >= 0 || errno != EACCES) _exit(static_cast<int>(i) + 1);
    }
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(pid, &status, 0), pid);
  close(folder_fd);
  close(pidfd);
  ASSERT_TRUE(WIFEXITED(status));
  const int code = WEXITSTATUS(status);
  if (code == 200) GTEST_SKIP() << "this kernel confines nobody";
  EXPECT_EQ(code, 0) << "allowed: "
                     << (code > 0 ? attempts.at(static_cast<size_t>(code) - 1).first : "");
  EXPECT_TRUE(fs::exists(file_) && fs::exists(empty) && !fs::exists(other));
}

}  // namespace
}  // namespace enamel::import
