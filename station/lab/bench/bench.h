#pragma once

#include <boost/json.hpp>
#include <string>

namespace CLI {
class App;
}

// `enamel-lab bench`, and the common parts of its subcommands: a progress line, a goal beside a
// figure, rows as JSON. Each subcommand is one file with one Register function, called by
// RegisterBench; its callback sets *exit_code, and `app` and `exit_code` outlive the parsing.
namespace enamel::station::lab::bench {

void RegisterBench(CLI::App& app, int* exit_code);

void RegisterTick(CLI::App& app, int* exit_code);
void RegisterMemory(CLI::App& app, int* exit_code);
void RegisterReplay(CLI::App& app, int* exit_code);
void RegisterScore(CLI::App& app, int* exit_code);
void RegisterSurface(CLI::App& app, int* exit_code);
void RegisterTimeline(CLI::App& app, int* exit_code);
void RegisterImport(CLI::App& app, int* exit_code);
void RegisterTarget(CLI::App& app, int* exit_code);
void RegisterRecord(CLI::App& app, int* exit_code);
void RegisterFrames(CLI::App& app, int* exit_code);
void RegisterIdle(CLI::App& app, int* exit_code);
void RegisterAnswers(CLI::App& app, int* exit_code);
void RegisterStorage(CLI::App& app, int* exit_code);

// One line on standard error, rewritten in place and erased at the end; at most ten times a second,
// and only on a terminal. A log gets only the rows.
class Progress {
 public:
  Progress() = default;
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void Show(const std::string& what, double ratio);
  // Erases the line, before a row is printed.
  void Clear();

 private:
  double shown_s_ = -1;
};

// "9.80 (goal <= 12: met)", "21.3 (goal <= 12: missed by 78 %)"; `at_least`: the goal is a floor.
std::string AgainstGoal(double value, double goal, bool at_least = false);

// The rows of one subcommand: {"format": 1, "subcommand", "method", "rows": [...]}.
class Rows {
 public:
  Rows(std::string subcommand, std::string method);
  void Add(boost::json::object row);
  // Writes them to `path`, or does nothing when it is empty. Returns a program's exit code, after
  // printing an error to standard error.
  int Write(const std::string& path) const;

 private:
  boost::json::object document_;
  boost::json::array rows_;
};
// Checks before a long measurement that `path` (or nothing, when empty) can be written.
bool CanWrite(const std::string& path);

}  // namespace enamel::station::lab::bench
