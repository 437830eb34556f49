#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <boost/json.hpp>
#include <csignal>
#include <cstdio>

#include "common/program/output.h"
#include "tests/load/arguments.h"
#include "tests/load/facts.h"

// enamel-loadgen.
namespace {

using namespace enamel;
using namespace enamel::load;

int Finish(const Arguments& a, LoadReport& report) {
  boost::json::object facts = Facts(a, report);
  for (const auto& member : facts) {
    std::printf("%-34s %s\n", std::string(member.key()).c_str(), ForPeople(member.value()).c_str());
  }
  if (!a.json.empty()) {
    Status written = program::WriteJsonFile(a.json, facts);
    if (!written.ok()) {
      std::fprintf(stderr, "enamel-loadgen: %s\n", written.message().c_str());
      return 1;
    }
  }
  if (Sound(report)) return 0;
  std::fprintf(stderr, "enamel-loadgen: not all that was sent is there once: %s\n",
               report.problem.empty() ? "see the figures" : report.problem.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kAbout);
  Arguments arguments;
  AddOptions(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::signal(SIGPIPE, SIG_IGN);  // a server that was killed is an error of the write
  spdlog::set_level(spdlog::level::warn);
  if (Status status = Complete(arguments, argv[0]); !status.ok()) {
    std::fprintf(stderr, "enamel-loadgen: %s\n", status.message().c_str());
    return 2;
  }
  auto report = RunLoad(
      arguments.load, [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); });
  if (!report.ok()) {
    std::fprintf(stderr, "enamel-loadgen: %s\n", report.status().message().c_str());
    return 1;
  }
  return Finish(arguments, *report);
}
