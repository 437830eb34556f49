#include "common/import/child_sandbox.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
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

// Memory, what is open already, time and the end. Nothing here reaches a file by its name, another
// process, or the network.
constexpr unsigned kAllowed[] = {SYS_read, SYS_write, SYS_readv, SYS_writev, SYS_lseek, SYS_fstat,
                                 SYS_close, SYS_brk, SYS_mmap, SYS_munmap, SYS_mremap, SYS_mprotect,
                                 SYS_madvise, SYS_futex, SYS_sched_yield, SYS_clock_gettime,
                                 SYS_gettimeofday, SYS_getrandom, SYS_getpid, SYS_gettid,
                                 // How much memory the machine has: qsort asks.
                                 SYS_sysinfo, SYS_rt_sigaction, SYS_rt_sigprocmask,
                                 SYS_rt_sigreturn, SYS_sigaltstack, SYS_exit, SYS_exit_group};

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
  // The thread that started this one waits for it.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
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
  for (unsigned call : kAllowed) {
    program.push_back(SkipUnlessEqual(call));
    program.push_back(Return(SECCOMP_RET_ALLOW));
  }
  // An error and no kill: the C library may ask for what it can do without.
  program.push_back(Return(SECCOMP_RET_ERRNO | EACCES));
  sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  // Without privileges the kernel takes a filter from a process only once it has given up gaining
  // any.
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter, 0, 0) == 0;
}

}  // namespace enamel::import
