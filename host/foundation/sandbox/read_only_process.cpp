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
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "host/foundation/base/processes/sanitizers.h"

namespace multum {
namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#else
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#endif
static_assert(std::endian::native == std::endian::little, "low_half() reads the first half of an argument");

#ifdef MULTUM_SHADOW_MEMORY
constexpr bool kHasSanitizer = true;
#else
constexpr bool kHasSanitizer = false;
#endif

// System calls that always fail with EPERM. Calls that the headers of Debian 12 lack have numbers here.
constexpr int kForbidden[] = {
    // Sockets. The process keeps the socket through which it is asked, and may use only recv() and send().
    SYS_socket,
    SYS_socketpair,
    SYS_connect,
    SYS_bind,
    SYS_listen,
    SYS_accept,
    SYS_accept4,
    SYS_sendmsg,
    SYS_sendmmsg,
    // Programs. Threads are allowed (clone, below).
    SYS_execve,
    SYS_execveat,
    SYS_unshare,
    SYS_setns,
#if defined(__x86_64__)
    SYS_fork,
    SYS_vfork,
#endif
    // Other processes.
    SYS_ptrace,
    SYS_process_vm_readv,
    SYS_process_vm_writev,
    SYS_process_madvise,
    448 /* process_mrelease */,
    SYS_pidfd_open,
    SYS_pidfd_getfd,
    SYS_pidfd_send_signal,
    SYS_tkill,
    SYS_kcmp,
    SYS_move_pages,
    SYS_migrate_pages,
    SYS_setpriority,
    SYS_ioprio_set,
    // Memory, queues and semaphores with names or numbers.
    SYS_shmget,
    SYS_shmat,
    SYS_shmctl,
    SYS_semget,
    SYS_semop,
    SYS_semtimedop,
    SYS_semctl,
    SYS_msgget,
    SYS_msgsnd,
    SYS_msgrcv,
    SYS_msgctl,
    SYS_mq_open,
    SYS_mq_unlink,
    SYS_mq_timedsend,
    SYS_mq_timedreceive,
    SYS_mq_notify,
    SYS_mq_getsetattr,
    // Limits of this process (prlimit64 below).
    SYS_setrlimit,
    // Files.
    SYS_truncate,
    SYS_unlinkat,
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
    SYS_name_to_handle_at,
    SYS_open_by_handle_at,
    SYS_inotify_init1,
    SYS_fanotify_init,
    SYS_fanotify_mark,
#if defined(__x86_64__)
    SYS_creat,
    SYS_unlink,
    SYS_rmdir,
    SYS_rename,
    SYS_renameat,
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
    SYS_inotify_init,
#else
    SYS_renameat,
#endif
    // Parts of the kernel that change the system, or that are large and not needed.
    SYS_io_uring_setup,
    SYS_io_setup,
    SYS_io_submit,
    SYS_bpf,
    SYS_seccomp,
    SYS_perf_event_open,
    SYS_userfaultfd,
    SYS_add_key,
    SYS_request_key,
    SYS_keyctl,
    SYS_mount,
    SYS_umount2,
    SYS_pivot_root,
    SYS_chroot,
    SYS_open_tree,
    467 /* open_tree_attr */,
    SYS_move_mount,
    SYS_fsopen,
    SYS_fsconfig,
    SYS_fsmount,
    SYS_fspick,
    SYS_mount_setattr,
    SYS_swapon,
    SYS_swapoff,
    SYS_quotactl,
    SYS_quotactl_fd,
    SYS_acct,
    SYS_syslog,
    SYS_sethostname,
    SYS_setdomainname,
    SYS_vhangup,
    SYS_settimeofday,
    SYS_clock_settime,
    SYS_clock_adjtime,
    SYS_adjtimex,
    SYS_init_module,
    SYS_finit_module,
    SYS_delete_module,
    SYS_kexec_load,
    SYS_kexec_file_load,
    SYS_reboot,
#if defined(__x86_64__)
    SYS_iopl,
    SYS_ioperm,
    SYS_modify_ldt,
#endif
};

// The offset of an argument's halves in seccomp_data.
constexpr std::uint32_t low_half(int argument) {
  return static_cast<std::uint32_t>(offsetof(seccomp_data, args)) + 8 * static_cast<std::uint32_t>(argument);
}
constexpr std::uint32_t high_half(int argument) { return low_half(argument) + 4; }

// A program for the kernel's packet filter, which decides about each system call.
class CallFilter {
 public:
  CallFilter() {
    load(offsetof(seccomp_data, arch));
    step(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0);
    fail(EPERM);
    load(offsetof(seccomp_data, nr));
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
  // Forbids the call if its argument, a number of 32 bits, has all of `bits` (or any of them, without `needs_all`).
  void forbid_bits(int call, int argument, std::uint32_t bits, bool needs_all, int error) {
    step(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 5);
    load(low_half(argument));
    step(BPF_ALU | BPF_AND | BPF_K, bits, 0, 0);
    if (needs_all) step(BPF_JMP | BPF_JEQ | BPF_K, bits, 0, 1);
    else step(BPF_JMP | BPF_JGT | BPF_K, 0, 0, 1);
    fail(error);
    load(offsetof(seccomp_data, nr));
  }
  // Forbids the call unless its argument, a number of 32 bits, has all of `bits`.
  void require_bits(int call, int argument, std::uint32_t bits) {
    step(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 5);
    load(low_half(argument));
    step(BPF_ALU | BPF_AND | BPF_K, bits, 0, 0);
    step(BPF_JMP | BPF_JEQ | BPF_K, bits, 1, 0);
    fail(EPERM);
    load(offsetof(seccomp_data, nr));
  }
  // Unless its argument, a number of 32 bits, is one of the values, the call is not made, and returns `error`.
  void allow_values(int call, int argument, std::initializer_list<std::uint32_t> values, int error = EPERM) {
    const auto count = static_cast<std::uint8_t>(values.size());
    step(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, static_cast<std::uint8_t>(count + 3));
    load(low_half(argument));
    std::uint8_t left = count;
    for (const std::uint32_t value : values) step(BPF_JMP | BPF_JEQ | BPF_K, value, left--, 0);
    fail(error);
    load(offsetof(seccomp_data, nr));
  }
  // Forbids the call unless its argument, a pointer, is null.
  void require_null(int call, int argument) {
    step(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 6);
    load(low_half(argument));
    step(BPF_JMP | BPF_JEQ | BPF_K, 0, 0, 2);
    load(high_half(argument));
    step(BPF_JMP | BPF_JEQ | BPF_K, 0, 1, 0);
    fail(EPERM);
    load(offsetof(seccomp_data, nr));
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

// Opening for writing fails as for a file of somebody else, because some libraries then open the file for reading.
void forbid_opening_for_writing(CallFilter& filter) {
  constexpr std::uint32_t kChanging = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | (O_TMPFILE & ~O_DIRECTORY);
  filter.forbid_bits(SYS_openat, 2, kChanging, false, EACCES);
#if defined(__x86_64__)
  filter.forbid_bits(SYS_open, 1, kChanging, false, EACCES);
#endif
  filter.forbid(SYS_openat2, ENOSYS);  // its flags are in memory, which a filter cannot read
}

// Descriptors that are open for reading only still let a process change attributes, take locks, and have signals sent
// to other processes.
void forbid_control_of_descriptors(CallFilter& filter) {
  constexpr std::uint32_t kDuplicateAndClose = 1030;  // F_DUPFD_CLOEXEC
  filter.allow_values(SYS_fcntl, 1, {F_DUPFD, F_GETFD, F_SETFD, F_GETFL, F_SETFL, kDuplicateAndClose});
  filter.forbid(SYS_ioctl, ENOTTY);
  filter.forbid(SYS_flock, ENOSYS);
  filter.allow_values(SYS_sendto, 5, {0});  // the length of the address: 0 for send()
}

void forbid_other_processes(CallFilter& filter) {
  const auto own = static_cast<std::uint32_t>(::getpid());
  // abort() sends a signal to this process.
  for (const int call : {SYS_kill, SYS_tgkill, SYS_rt_sigqueueinfo, SYS_rt_tgsigqueueinfo})
    filter.allow_values(call, 0, {own});
  // A thread may be any thread of this process, or another process. Threads that set their processors must not fail.
  constexpr int kPretendSuccess = 0;
  for (const int call : {SYS_sched_setaffinity, SYS_sched_setscheduler, SYS_sched_setparam, SYS_sched_setattr})
    filter.allow_values(call, 0, {0, own}, kPretendSuccess);
  filter.require_bits(SYS_clone, 0, CLONE_THREAD);
  filter.forbid(SYS_clone3, ENOSYS);  // its flags are in memory; the C library then uses clone
}

void forbid_raising_limits(CallFilter& filter) {
  filter.allow_values(SYS_prlimit64, 0, {0, static_cast<std::uint32_t>(::getpid())});
  filter.require_null(SYS_prlimit64, 2);
  // Memory that the limit of this process does not count.
  filter.forbid(SYS_memfd_create, ENOSYS);
  filter.forbid_bits(SYS_mmap, 3, MAP_SHARED | MAP_ANONYMOUS, true, EPERM);
}

}  // namespace

bool can_confine_to_reading() {
  const std::uint32_t action = SECCOMP_RET_ERRNO;
  return !kHasSanitizer && ::syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) == 0;
}

bool confine_to_reading() {
  if (!can_confine_to_reading()) return false;
  CallFilter filter;
  for (const int call : kForbidden) filter.forbid(call);
  forbid_opening_for_writing(filter);
  forbid_control_of_descriptors(filter);
  forbid_other_processes(filter);
  forbid_raising_limits(filter);
  return filter.install();
}

}  // namespace multum

#endif
