// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/sandbox/read_only_process.h"

#if !defined(__x86_64__) && !defined(__aarch64__)

namespace multum {

bool can_confine_to_reading() { return false; }
bool confine_to_reading() { return false; }

}  // namespace multum

#else

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/sandbox/confinement.h"

namespace multum {
namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#else
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#endif
static_assert(std::endian::native == std::endian::little, "low_word() reads the first half of an argument");

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kHasAddressSanitizer = true;
#else
constexpr bool kHasAddressSanitizer = false;
#endif

// System calls that always fail with EPERM. Calls of newer kernels that the headers of Debian 12 lack have numbers
// here.
constexpr int kForbidden[] = {
    // sockets
    SYS_socket,
    SYS_connect,
    SYS_bind,
    SYS_listen,
    SYS_accept,
    SYS_accept4,
    // programs
    SYS_execve,
    SYS_execveat,
    // other processes, and memory and queues that are shared by name
    SYS_ptrace,
    SYS_process_vm_readv,
    SYS_process_vm_writev,
    SYS_pidfd_open,
    SYS_pidfd_getfd,
    SYS_pidfd_send_signal,
    SYS_tkill,
    SYS_kcmp,
    SYS_move_pages,
    SYS_migrate_pages,
    SYS_setpriority,
    SYS_ioprio_set,
    SYS_process_madvise,
    SYS_shmget,
    SYS_shmat,
    SYS_semget,
    SYS_msgget,
    SYS_mq_open,
    SYS_mq_unlink,
    // parts of the kernel that are large or change the system
    SYS_io_uring_setup,
    SYS_bpf,
    SYS_perf_event_open,
    SYS_userfaultfd,
    SYS_add_key,
    SYS_request_key,
    SYS_keyctl,
    SYS_unshare,
    SYS_setns,
    SYS_mount,
    SYS_umount2,
    SYS_pivot_root,
    SYS_chroot,
    SYS_open_tree,
    SYS_move_mount,
    SYS_fsopen,
    SYS_fsconfig,
    SYS_fsmount,
    SYS_fspick,
    SYS_mount_setattr,
    SYS_open_by_handle_at,
    SYS_swapon,
    SYS_swapoff,
    SYS_quotactl,
    SYS_init_module,
    SYS_finit_module,
    SYS_delete_module,
    SYS_kexec_load,
    SYS_reboot,
    // files
    SYS_truncate,
    SYS_unlinkat,
    SYS_renameat,
    SYS_renameat2,
    SYS_mkdirat,
    SYS_linkat,
    SYS_symlinkat,
    SYS_mknodat,
    SYS_fchmod,
    SYS_fchmodat,
    452 /* fchmodat2 */,
    SYS_fchown,
    SYS_fchownat,
    SYS_utimensat,
    SYS_setxattr,
    SYS_lsetxattr,
    SYS_fsetxattr,
    463 /* setxattrat */,
    SYS_removexattr,
    SYS_lremovexattr,
    SYS_fremovexattr,
    466 /* removexattrat */,
    469 /* file_setattr */,
#if defined(__x86_64__)
    SYS_creat,
    SYS_unlink,
    SYS_rmdir,
    SYS_rename,
    SYS_mkdir,
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
};

// The number of the call, or of the low half of an argument, in seccomp_data.
constexpr std::uint32_t kCall = offsetof(seccomp_data, nr);
constexpr std::uint32_t low_word(int argument) {
  return static_cast<std::uint32_t>(offsetof(seccomp_data, args)) + 8 * static_cast<std::uint32_t>(argument);
}

// A program for the kernel's packet filter, which decides about each system call.
class CallFilter {
 public:
  CallFilter() {
    load(offsetof(seccomp_data, arch));
    step(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0);
    fail(EPERM);
    load(kCall);
#if defined(__x86_64__)
    constexpr std::uint32_t kX32 = 0x40000000;  // calls with 32-bit pointers have the same architecture
    step(BPF_JMP | BPF_JGE | BPF_K, kX32, 0, 1);
    fail(EPERM);
#endif
  }

  void forbid(int call, int error = EPERM) {
    step(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 1);
    fail(error);
  }
  // Forbids the call if its argument has one of the bits.
  void forbid_bits(int call, int argument, std::uint32_t bits) {
    step(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4);
    load(low_word(argument));
    step(BPF_JMP | BPF_JSET | BPF_K, bits, 0, 1);
    fail(EPERM);
    load(kCall);
  }
  // Forbids the call if its argument has this value.
  void forbid_value(int call, int argument, std::uint32_t value) {
    step(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4);
    load(low_word(argument));
    step(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
    fail(EPERM);
    load(kCall);
  }
  // Forbids the call unless its argument has one of two values.
  void allow_values(int call, int argument, std::uint32_t first, std::uint32_t second) {
    step(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 5);
    load(low_word(argument));
    step(BPF_JMP | BPF_JEQ | BPF_K, first, 2, 0);
    step(BPF_JMP | BPF_JEQ | BPF_K, second, 1, 0);
    fail(EPERM);
    load(kCall);
  }

  bool install() {
    step(BPF_RET | BPF_K, SECCOMP_RET_ALLOW, 0, 0);
    const sock_fprog program = {static_cast<unsigned short>(steps_.size()), steps_.data()};
    return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0;
  }

 private:
  void step(int code, std::uint32_t value, std::uint8_t if_true, std::uint8_t if_false) {
    steps_.push_back({static_cast<std::uint16_t>(code), if_true, if_false, value});
  }
  void load(std::size_t offset) { step(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset), 0, 0); }
  void fail(int error) { step(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(error), 0, 0); }

  std::vector<sock_filter> steps_;
};

}  // namespace

bool can_confine_to_reading() {
  const std::uint32_t action = SECCOMP_RET_ERRNO;
  return !kHasAddressSanitizer && ::syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) == 0;
}

bool confine_to_reading() {
  if (!can_confine_to_reading()) return false;
  try {
    confine_this_thread({.readable = {"/"}, .writable = {}});
  } catch (const Error&) {
    // The filter forbids these calls too. Landlock fails, for example, in a process that is already confined 16 times.
  }
  CallFilter filter;
  for (const int call : kForbidden) filter.forbid(call);
  filter.forbid(SYS_openat2, ENOSYS);  // its flags are in memory, which a filter cannot read
  constexpr std::uint32_t kChanging = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | (O_TMPFILE & ~O_DIRECTORY);
  filter.forbid_bits(SYS_openat, 2, kChanging);
#if defined(__x86_64__)
  filter.forbid_bits(SYS_open, 1, kChanging);
#endif
  // These requests put characters into the input of a terminal.
  constexpr std::uint32_t kConsoleRequest = 0x541C;  // TIOCLINUX
  filter.forbid_value(SYS_ioctl, 1, TIOCSTI);
  filter.forbid_value(SYS_ioctl, 1, kConsoleRequest);
  // abort() sends a signal to this process, and threads read their own limits.
  const auto own = static_cast<std::uint32_t>(::getpid());
  for (const int call : {SYS_kill, SYS_tgkill, SYS_rt_sigqueueinfo, SYS_rt_tgsigqueueinfo})
    filter.allow_values(call, 0, own, own);
  filter.allow_values(SYS_prlimit64, 0, own, 0);
  return filter.install();
}

}  // namespace multum

#endif
