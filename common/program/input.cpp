#include "common/program/input.h"

#include <iostream>

#include "common/base/file.h"

namespace enamel::program {

Result<std::string> ReadInput(const std::filesystem::path& file, size_t max_bytes) {
  if (file != "-") {
    ENAMEL_ASSIGN_OR_RETURN(const Bytes bytes, ReadFile(file, max_bytes));
    return std::string(AsText(bytes));
  }
  // Not /dev/stdin: that opens the file again, which the command's user may not be allowed to.
  std::string text(max_bytes + 1, '\0');
  std::cin.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(std::cin.gcount()));
  if (text.size() <= max_bytes) return text;
  return Status(Code::kTooLarge, "standard input is larger than the " + std::to_string(max_bytes) +
                                     " bytes allowed here");
}

}  // namespace enamel::program
