#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>

#include "tests/bench/cutting/bench.h"

// The figures of the cutting core, each with the method it was got by and the goal beside it.
int main(int argc, char** argv) {
  CLI::App app(
      "enamel-bench: what the cutting core costs. Every subcommand prints its method, its figures "
      "and the goal beside each; --json writes the rows.");
  app.footer(
      "Figures depend on the machine and on what else it does: the least of several identical\n"
      "replays is the code's own cost, the raw figures beside it are what a user saw.\n"
      "Examples:\n"
      "  enamel-bench tick                        # burs x voxel sizes x speeds\n"
      "  enamel-bench tick --quick --json t.json  # the headline case only\n"
      "Exit codes: 0 measured (goals met or not), 1 failed, 2 wrong command line.");
  app.require_subcommand(1);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  int exit_code = 0;
  enamel::bench::RegisterTick(app, &exit_code);
  enamel::bench::RegisterMemory(app, &exit_code);
  enamel::bench::RegisterReplay(app, &exit_code);
  enamel::bench::RegisterSurface(app, &exit_code);
  enamel::bench::RegisterImport(app, &exit_code);
  enamel::bench::RegisterRecord(app, &exit_code);
  enamel::bench::RegisterError(app, &exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::cerr << "enamel-bench: " << error.what() << '\n';
    return 1;
  }
  return exit_code;
}
