#include "station/lab/bench/bench.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "common/program/example.h"
#include "common/program/log.h"
#include "common/program/output.h"

namespace enamel::station::lab::bench {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Progress::~Progress() { Clear(); }

void Progress::Clear() {
  if (shown_s_ >= 0) std::fprintf(stderr, "\r%80s\r", "");
  shown_s_ = -1;
}

void Progress::Show(const std::string& what, double ratio) {
  if (!::isatty(STDERR_FILENO)) return;
  double now = Now();
  // A terminal is slow, and the measured code runs on the same cores.
  if (shown_s_ >= 0 && now - shown_s_ < 0.1) return;
  shown_s_ = now;
  std::fprintf(stderr, "\r%-66.66s %3.0f %%", what.c_str(), 100 * ratio);
  std::fflush(stderr);
}

std::string AgainstGoal(double value, double goal, bool at_least) {
  // A missed goal is reported, but is no error: a slower computer is not broken.
  bool met = at_least ? value >= goal : value <= goal;
  char text[120];
  if (met) {
    std::snprintf(text, sizeof text, "%.4g (goal %s %g: met)", value, at_least ? ">=" : "<=", goal);
  } else {
    // By how much, since a goal missed by 3 % on another machine means little.
    std::snprintf(text, sizeof text, "%.4g (goal %s %g: missed by %.0f %%)", value,
                  at_least ? ">=" : "<=", goal, 100 * std::fabs(value / goal - 1));
  }
  return text;
}

Rows::Rows(std::string subcommand, std::string method)
    : document_{
          {"format", 1}, {"subcommand", std::move(subcommand)}, {"method", std::move(method)}} {}

void Rows::Add(boost::json::object row) { rows_.push_back(std::move(row)); }

int Rows::Write(const std::string& path) const {
  if (path.empty()) return 0;
  boost::json::object out = document_;
  out["rows"] = rows_;
  Status status = program::WriteJsonFile(path, out);
  if (status.ok()) return 0;
  program::SayError(status.message());
  return 1;
}

bool CanWrite(const std::string& path) {
  // Before measuring: minutes must not be lost over a path.
  Status status = program::CheckOutputFile(path, "--json");
  if (!status.ok()) program::SayError(status.message());
  return status.ok();
}

void RegisterBench(CLI::App& app, int* exit_code) {
  CLI::App* bench = app.add_subcommand(
      "bench",
      "What the cutting core and a picture cost here: method, figures, the goal beside each");
  bench->require_subcommand(1);
  RegisterTick(*bench, exit_code);
  RegisterMemory(*bench, exit_code);
  RegisterReplay(*bench, exit_code);
  RegisterScore(*bench, exit_code);
  RegisterSurface(*bench, exit_code);
  RegisterTimeline(*bench, exit_code);
  RegisterImport(*bench, exit_code);
  RegisterTarget(*bench, exit_code);
  RegisterRecord(*bench, exit_code);
  RegisterFrames(*bench, exit_code);
  RegisterIdle(*bench, exit_code);
  RegisterAnswers(*bench, exit_code);
  RegisterStorage(*bench, exit_code);
  // After its commands, which would inherit it.
  bench->footer(
      "Figures depend on the machine and on what else it does: the least of several identical\n"
      "replays is the code's own cost, the raw figures beside it are what a user saw.\n"
      "Exit codes: 0 measured (goals met or not), 1 failed, 2 wrong command line.");
  program::AddExamples(*bench, {"tick --quick"});
}

}  // namespace enamel::station::lab::bench
