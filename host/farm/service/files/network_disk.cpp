// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/files/network_disk.h"

#include <fmt/format.h>
#include <sys/vfs.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

// The numbers are from linux/magic.h and from the sources of the file systems.
constexpr std::array<std::pair<std::uint32_t, const char*>, 22> kNetworkDisks = {{
    {0x6969, "NFS"},
    {0x517b, "SMB"},
    {0xff534d42, "CIFS"},
    {0xfe534d42, "SMB 2"},
    {0x0bd00bd0, "Lustre"},
    {0x65735546, "FUSE, such as sshfs, GlusterFS and virtiofs"},
    {0x00c36400, "Ceph"},
    {0x5346414f, "AFS"},
    {0x6b414653, "AFS"},
    {0x73757245, "Coda"},
    {0x564c, "NCP"},
    {0x01021997, "9P"},
    {0x47504653, "GPFS"},
    {0x01161970, "GFS2"},
    {0x7461636f, "OCFS2"},
    {0x19830326, "BeeGFS"},
    {0xaad7aaea, "PanFS"},
    {0x20030528, "OrangeFS"},
    {0xbacbacbc, "VMware's shared folders"},
    {0x786f4256, "VirtualBox's shared folders"},
    {0x7c7c6673, "Parallels' shared folders"},
    {0x61636673, "ACFS"},
}};

}  // namespace

std::string network_disk_name(std::int64_t type) {
  // The sign and width of f_type depend on the machine. The numbers themselves have 32 bits.
  const auto number = static_cast<std::uint32_t>(type);
  const auto found =
      std::find_if(kNetworkDisks.begin(), kNetworkDisks.end(), [&](const auto& one) { return one.first == number; });
  return found == kNetworkDisks.end() ? "" : found->second;
}

void check_is_local(const std::string& folder) {
  struct statfs found {};
  int result = -1;
  do result = ::statfs(folder.c_str(), &found);
  while (result != 0 && errno == EINTR);
  if (result != 0) fail_by_errno(folder, "cannot examine its file system");
  const std::string name = network_disk_name(static_cast<std::int64_t>(found.f_type));
  if (!name.empty())
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: is on a network file system ({}), where a ledger is not safe; expected a local disk. "
                            "Name another folder with --data; roots may be on a network",
                            folder, name));
}

}  // namespace multum
