#include "station/uplink/private_folder.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace enamel::station {
namespace {

Status Cannot(const std::filesystem::path& folder, const std::string& why) {
  return Status(Code::kStorage, "cannot create the folder " + folder.string() + " (" + why +
                                    "): choose another with --data");
}

}  // namespace

Status MakePrivateFolder(const std::filesystem::path& named) {
  const std::filesystem::path folder = named.has_filename() ? named : named.parent_path();
  std::error_code error;
  if (folder.has_parent_path()) std::filesystem::create_directories(folder.parent_path(), error);
  if (error) return Cannot(folder, error.message());
  if (::mkdir(folder.c_str(), 0700) == 0) return Status::Ok();
  int why = errno;
  if (why == EEXIST && std::filesystem::is_directory(folder, error)) return Status::Ok();
  return Cannot(folder, std::strerror(why));
}

}  // namespace enamel::station
