#include "common/import/child_sandbox.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#include <cerrno>
#include <cstddef>
#include <vector>

#if defined(__SANITIZE_ADDRESS__)
// The leak check at exit starts a process of its own, which is forbidden here.
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }
#endif

namespace enamel::import {
namespace {

void Limit(__rlimit_resource what, rlim_t value) {
  rlimit limit{value, value};
  setrlimit(what, &limit);
}

// Calls that are not named here are allowed.
const std::vector<unsigned> kForbidden = {
#ifdef SYS_open
    SYS_open,
#endif
#ifdef SYS_creat
    SYS_creat,
#endif
#ifdef SYS_fork
    SYS_fork,
#endif
#ifdef SYS_vfork
    SYS_vfork,
#endif
// Calls of the file system that newer machines have only as their *at forms.
#ifdef SYS_unlink
    SYS_unlink,
    SYS_rename,
    SYS_mkdir,
    SYS_rmdir,
    SYS_link,
    SYS_symlink,
    SYS_mknod,
    SYS_chmod,
    SYS_chown,
    SYS_lchown,
    SYS_utime,
    SYS_utimes,
    SYS_futimesat,
#endif
#ifdef SYS_renameat
    SYS_renameat,
#endif
    SYS_renameat2,
    SYS_unlinkat,
    SYS_mkdirat,
    SYS_linkat,
    SYS_symlinkat,
    SYS_mknodat,
    SYS_truncate,
    SYS_fchmodat,
    SYS_fchownat,
    SYS_utimensat,
    SYS_setxattr,
    SYS_lsetxattr,
    SYS_removexattr,
    SYS_lremovexattr,
    SYS_fchmod,
    SYS_fchown,
    SYS_kill,
    SYS_openat,
    SYS_openat2,
    SYS_socket,
    SYS_socketpair,
    SYS_connect,
    SYS_bind,
    SYS_execve,
    SYS_execveat,
    SYS_clone,
    SYS_clone3,
    SYS_ptrace,
    SYS_process_vm_writev,
    SYS_io_uring_setup};

#if defined(__x86_64__)
constexpr unsigned kArch = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr unsigned kArch = AUDIT_ARCH_AARCH64;
#else
constexpr unsigned kArch = 0;
#endif

sock_filter Load(unsigned offset) { return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offset); }
sock_filter Return(unsigned action) { return BPF_STMT(BPF_RET | BPF_K, action); }
sock_filter SkipUnlessEqual(unsigned value) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
}

}  // namespace

void LimitResources() {
  Limit(RLIMIT_CPU, 60);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // The sanitizers reserve terabytes of addresses and could not start.
  Limit(RLIMIT_AS, rlim_t{4} << 30);
#endif
  Limit(RLIMIT_FSIZE, 0);
  Limit(RLIMIT_CORE, 0);
}

bool ForbidSystem() {
  if (kArch == 0) return false;
  std::vector<sock_filter> program = {
      Load(offsetof(seccomp_data, arch)), BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArch, 1, 0),
      Return(SECCOMP_RET_KILL_PROCESS), Load(offsetof(seccomp_data, nr)),
      // The x32 numbers of the same calls.
      BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, 0x40000000u, 0, 1), Return(SECCOMP_RET_KILL_PROCESS)};
  for (unsigned call : kForbidden) {
    program.push_back(SkipUnlessEqual(call));
    // An error and no kill: the library may look for a file that it can do without.
    program.push_back(Return(SECCOMP_RET_ERRNO | EACCES));
  }
  program.push_back(Return(SECCOMP_RET_ALLOW));
  sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  // Without privileges the kernel takes a filter from a process only once it has given up gaining
  // any.
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter, 0, 0) == 0;
}

}  // namespace enamel::import
