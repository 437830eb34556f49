#include "server/ops/full_house.h"

#include <unordered_map>

namespace enamel::server::ops {

std::optional<size_t> WhoMakesRoom(const std::vector<Guest>& first_come_first) {
  struct Crowd {
    size_t size = 0, first = 0;
  };
  std::unordered_map<std::string_view, Crowd> crowds;
  const Crowd* largest = nullptr;
  for (size_t i = 0; i < first_come_first.size(); ++i) {
    if (!first_come_first[i].may_go) continue;
    Crowd& crowd = crowds.try_emplace(first_come_first[i].block, Crowd{0, i}).first->second;
    ++crowd.size;
    if (largest == nullptr || crowd.size > largest->size) largest = &crowd;
  }
  if (largest == nullptr) return std::nullopt;
  return largest->first;
}

}  // namespace enamel::server::ops
