#include "common/program/beside.h"

#include <unistd.h>

#include <cstdio>

#include "common/base/file.h"

namespace enamel::program {

Status ReplaceBy(const std::string& name, std::vector<std::string> arguments) {
  std::string file = (OwnFolder() / name).string();
  std::vector<char*> argv{file.data()};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  std::fflush(nullptr);
  ::execv(file.c_str(), argv.data());
  return Status(Code::kNotFound, "there is no program " + file);
}

}  // namespace enamel::program
