#pragma once

#include <chrono>
#include <thread>

namespace enamel::test {

// Retries for at most ten seconds.
template <typename Is>
bool Becomes(const Is& is) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!is()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace enamel::test
