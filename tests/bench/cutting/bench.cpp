#include "tests/bench/cutting/bench.h"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "common/base/file.h"

namespace enamel::bench {
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
  if (shown_s_ >= 0 && now - shown_s_ < 0.1) return;
  shown_s_ = now;
  std::fprintf(stderr, "\r%-66.66s %3.0f %%", what.c_str(), 100 * ratio);
  std::fflush(stderr);
}

std::string AgainstGoal(double value, double goal, bool at_least) {
  bool met = at_least ? value >= goal : value <= goal;
  char text[120];
  if (met) {
    std::snprintf(text, sizeof text, "%.4g (goal %s %g: met)", value, at_least ? ">=" : "<=", goal);
  } else {
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
  Status status = WriteFileDurably(path, AsBytes(boost::json::serialize(out) + "\n"));
  if (status.ok()) return 0;
  std::fprintf(stderr, "enamel-bench: %s\n", status.message().c_str());
  return 1;
}

bool CanWrite(const std::string& path) {
  if (path.empty()) return true;
  bool there = static_cast<bool>(std::ifstream(path));
  bool ok = static_cast<bool>(std::ofstream(path, std::ios::app));
  if (!there && ok) std::remove(path.c_str());
  if (!ok) {
    std::fprintf(stderr,
                 "enamel-bench: --json %s cannot be written: name a file in a folder that can be\n",
                 path.c_str());
  }
  return ok;
}

}  // namespace enamel::bench
