#include "common/program/output.h"

#include <unistd.h>

#include <boost/json.hpp>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "common/base/file.h"

namespace enamel::program {
namespace {

namespace fs = std::filesystem;

Status Cannot(const char* option, const fs::path& path, const std::string& why) {
  return Status(Code::kStorage, std::string(option) + ": cannot write " + path.string() + " (" +
                                    why + "): name a place that this user may write");
}

// The fewest digits that read back as the same number, and still as one that is no integer.
std::string NumberText(double number) {
  const double size = std::fabs(number);
  const auto format = size == 0 || (size >= 1e-4 && size < 1e15) ? std::chars_format::fixed
                                                                 : std::chars_format::scientific;
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, number, format).ptr;
  std::string out(text, end);
  if (out.find_first_of(".e") == std::string::npos) out += ".0";
  return out;
}

void Append(const boost::json::value& value, std::string& out) {
  const char* between = "";
  if (const auto* object = value.if_object()) {
    out += '{';
    for (const auto& [name, member] : *object) {
      out += std::exchange(between, ",") + boost::json::serialize(name) + ':';
      Append(member, out);
    }
    out += '}';
  } else if (const auto* array = value.if_array()) {
    out += '[';
    for (const auto& element : *array) {
      out += std::exchange(between, ",");
      Append(element, out);
    }
    out += ']';
  } else if (const double* number = value.if_double(); number && std::isfinite(*number)) {
    out += NumberText(*number);
  } else {
    out += boost::json::serialize(value);
  }
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

std::string JsonText(const boost::json::value& value) {
  std::string out;
  Append(value, out);
  return out;
}

Status WriteJsonFile(const fs::path& file, const boost::json::object& object) {
  if (file.empty()) return Status::Ok();
  return WriteFileDurably(file, AsBytes(JsonText(object) + "\n"));
}

}  // namespace enamel::program
