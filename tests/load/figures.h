#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace enamel::load {

// The value at share p (0 to 1), by rank; 0 if there are none. Reorders the values.
double Quantile(std::vector<float>& values, double p);
double Median(std::vector<double> values);

// One engine's counts while it streamed.
struct StreamFigures {
  uint64_t ticks_sent = 0;        // handed to the network at least once
  uint64_t ticks_committed = 0;   // known to be committed
  uint64_t ticks_taken_back = 0;  // committed once, and asked for again by the server: lost
  uint64_t bytes_sent = 0;        // frames of chunks, repeats included
  uint64_t chunk_bytes = 0;       // chunks, each once
  uint64_t reconnects = 0, repeats = 0, disorders = 0, cuts = 0;
  uint64_t refused = 0;  // chunks that a server answered with an error, out of turn apart
  uint64_t live_states = 0;
  std::vector<float> commit_ms;  // from a chunk's last byte sent to its commit received
  std::vector<float> late_ms;    // from the moment a chunk was due to its first byte sent

  void Add(StreamFigures&& other);
};

}  // namespace enamel::load
