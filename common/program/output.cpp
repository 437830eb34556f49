#include "common/program/output.h"

#include <unistd.h>

#include <boost/json.hpp>
#include <cerrno>
#include <cstring>
#include <string>

#include "common/base/file.h"

namespace enamel::program {
namespace {

namespace fs = std::filesystem;

Status Cannot(const char* option, const fs::path& path, const std::string& why) {
  return Status(Code::kStorage, std::string(option) + ": cannot write " + path.string() + " (" +
                                    why + "): name a place that this user may write");
}

Status CheckWritableFolder(const char* option, const fs::path& path, const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return Cannot(
        option, path,
        folder.string() + (fs::exists(folder, error) ? " is no folder" : " is not there"));
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    return Cannot(option, path, folder.string() + ": " + std::strerror(errno));
  }
  return Status::Ok();
}

}  // namespace

Status CheckOutputFile(const fs::path& file, const char* option) {
  if (file.empty()) return Status::Ok();
  std::error_code error;
  if (fs::is_directory(file, error)) return Cannot(option, file, "it is a folder");
  // The folder's rights count, not the file's: WriteFileDurably makes a file beside it and renames.
  fs::path folder = file.parent_path();
  return CheckWritableFolder(option, file, folder.empty() ? fs::path(".") : folder);
}

Status CheckOutputFolder(const fs::path& folder, const char* option) {
  std::error_code error;
  // Without "..": the parent of a path through one need not be where the folder will be made.
  fs::path nearest = fs::absolute(folder, error).lexically_normal();
  while (!fs::exists(nearest, error) && nearest.has_relative_path()) {
    nearest = nearest.parent_path();
  }
  return CheckWritableFolder(option, folder, nearest);
}

Status CheckNewIn(const fs::path& folder, const char* file, const char* option) {
  std::error_code error;
  if (!fs::exists(folder / file, error)) return Status::Ok();
  return Status(Code::kConflict,
                std::string(option) + ": " + folder.string() + " has a " + file +
                    " already, and nothing is overwritten: name another folder, or remove it first",
                option);
}

Status WriteJsonFile(const fs::path& file, const boost::json::object& object) {
  if (file.empty()) return Status::Ok();
  return WriteFileDurably(file, AsBytes(boost::json::serialize(object) + "\n"));
}

}  // namespace enamel::program
