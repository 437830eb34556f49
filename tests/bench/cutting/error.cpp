#include <unistd.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "station/qualify/qualify.h"
#include "tests/bench/cutting/bench.h"

namespace enamel::bench {

void RegisterError(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<station::qualify::QualifyOptions>();
  options->suites = {"cutting"};
  options->out = stdout;
  options->errors = [](const std::string& why) {
    std::fprintf(stderr, "enamel-bench: %s\n", why.c_str());
  };
  CLI::App* error = app.add_subcommand(
      "error",
      "Error against run time of cutting, as `enamel-station qualify --suite cutting` measures it");
  error->add_flag("--quick", options->quick, "Two burs, one speed, two voxel sizes, no scores");
  error->add_option("--json", options->json_path, "Write the rows to this file");
  error->add_option("--report", options->report_dir,
                    "Write report.html with the Pareto front into this folder");
  error->callback([options, exit_code] {
    if (!CanWrite(options->json_path)) {
      *exit_code = 1;
      return;
    }
    if (::isatty(STDERR_FILENO)) options->progress = stderr;
    *exit_code = station::qualify::RunQualify(*options);
  });
}

}  // namespace enamel::bench
