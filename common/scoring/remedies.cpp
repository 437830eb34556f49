#include "common/scoring/remedies.h"

namespace enamel::scoring {
namespace {

constexpr Remedy kPressLess = {"heavy_hand", "do_lighter"};

}  // namespace

const Remedy* FindRemedy(std::string_view metric, bool above) {
  const bool force = metric == "force_sent_p95_n" || metric == "force_sent_max_n";
  return force && above ? &kPressLess : nullptr;
}

std::string_view RemedyText(std::string_view code) {
  return code == kPressLess.code ? "Press less and let the bur cut" : "";
}

}  // namespace enamel::scoring
