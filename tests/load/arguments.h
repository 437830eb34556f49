#pragma once

#include <filesystem>
#include <string>

#include "tests/load/load.h"

namespace CLI {
class App;
}

// The command line of enamel-loadgen.
namespace enamel::load {

inline constexpr char kAbout[] =
    "Many stations against one server: what arrives, how soon, and what it costs.\n\n"
    "Starts an enamel-server of its own on loopback with scoring paused, enrols the stations over\n"
    "the station link, lets each stream a recorded movement of its own at 1 kHz over TLS, seals "
    "the\n"
    "attempts, and compares every trace in the store with what was sent, byte by byte. Chunks are\n"
    "encoded and signed before the clock starts.\n\n"
    "  enamel-loadgen --stations 1000 --minutes 5 --json load.json\n"
    "  enamel-loadgen --stations 100 --minutes 2 --kills 5 --cuts 50 --hostile 25\n"
    "  enamel-loadgen --stations 200 --minutes 1 --api-reads 20\n"
    "  enamel-loadgen --stations 200 --minutes 4 --score-attempts 42\n"
    "  enamel-loadgen --stations 500 --minutes 3 --viewers 50 --alternate 3\n"
    "  enamel-loadgen --idle 10000 --minutes 1\n"
    "  enamel-loadgen --stations 50 --server 127.0.0.1:8443 --data DIR   (a server that runs)\n\n"
    "Exit codes: 0 all that was committed is there once; 1 not, or it could not run; 2 wrong "
    "usage.";

struct Arguments {
  LoadOptions load;
  double minutes = 1;
  size_t score_attempts = 0;
  Marking::Options marking;
  std::string server, page;
  std::filesystem::path json;
};

// `a` outlives `app`.
void AddOptions(CLI::App& app, Arguments& a);
// Computes values that depend on several options; call after parsing. `program` is this program's
// path. Errors: kInvalidInput, when options contradict each other.
Status Complete(Arguments& a, const char* program);

}  // namespace enamel::load
