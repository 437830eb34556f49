#include "server/http/handlers/feel_maps.h"

#include <algorithm>
#include <cstdio>

namespace enamel::server::http {
namespace {

// All that a map depends on, and nothing else: a profile saved again under another title needs no
// new one.
std::string KeyOf(const fidelity::Device& d, const std::vector<fidelity::Tissue>& tissues) {
  char text[200];
  // %a is exact: two devices share a map when all their numbers are the same bits, and never by
  // rounding.
  std::snprintf(text, sizeof text, "%a %a %a %d %a %a", d.resolution_m, d.kc_n_per_m, d.tick_s,
                d.delay_ticks, d.peak_force_n, d.continuous_force_n);
  std::string key = text;
  for (const fidelity::Tissue& t : tissues) {
    std::snprintf(text, sizeof text, " / %a %a %a", t.b_n_s_per_m, t.coulomb_n, t.threshold_n);
    key += text;
  }
  return key;
}

}  // namespace

std::shared_ptr<const FeelMaps::Map> FeelMaps::Of(const fidelity::Device& device,
                                                  const std::vector<fidelity::Tissue>& tissues) {
  std::string key = KeyOf(device, tissues);
  auto found = std::ranges::find(kept_, key, &Entry::key);
  if (found != kept_.end()) return found->map;
  auto map = std::make_shared<const Map>(fidelity::MapOf(device, tissues));
  ++computed_;
  // The oldest goes, not the least used: with one school's devices it never comes to it.
  if (kept_.size() == kKept) kept_.pop_front();
  kept_.push_back({std::move(key), map});
  return map;
}

}  // namespace enamel::server::http
