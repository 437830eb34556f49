#include <string>
#include <vector>

#include "common/program/beside.h"
#include "common/program/log.h"

// enamel-bench, the older name of `enamel-lab bench`, and of `enamel-lab error` for its "error".
int main(int argc, char** argv) {
  using namespace enamel;
  std::vector<std::string> arguments(argv + 1, argv + argc);
  // "error" is a separate command; the other old benches are under `bench`.
  if (arguments.empty() || arguments[0] != "error") arguments.insert(arguments.begin(), "bench");
  (void)program::SetUpLog({.name = "enamel-bench"});
  const Status failed = program::ReplaceBy("enamel-lab", std::move(arguments));
  program::SayError(failed.message() + ": build it beside this one, 'ninja -C BUILD enamel-lab'");
  return 1;
}
