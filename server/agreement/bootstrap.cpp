#include "server/agreement/bootstrap.h"

#include <algorithm>
#include <random>

namespace enamel::server {

std::optional<Interval> BootstrapInterval(
    size_t works, const std::function<std::optional<double>(const std::vector<size_t>&)>& figure) {
  constexpr uint64_t kSeed = 1;
  constexpr double kBeyond = 0.025;
  // Its numbers are the standard's, not the library's; a distribution's would be the library's.
  std::mt19937_64 random(kSeed);
  std::vector<size_t> drawn(works);
  std::vector<double> found;
  for (int draw = 0; draw < kBootstrapDraws; ++draw) {
    for (size_t& i : drawn) i = random() % works;
    if (auto value = figure(drawn)) found.push_back(*value);
  }
  if (found.size() < kBootstrapDraws / 2) return std::nullopt;
  std::ranges::sort(found);
  const auto last = static_cast<double>(found.size() - 1);
  auto at = [&](double share) { return found[static_cast<size_t>(share * last + 0.5)]; };
  return Interval{at(kBeyond), at(1 - kBeyond)};
}

}  // namespace enamel::server
