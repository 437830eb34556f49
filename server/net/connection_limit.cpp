#include "server/net/connection_limit.h"

#include <unordered_map>

namespace enamel::server {

std::optional<size_t> PickToClose(const std::vector<Closable>& oldest_first) {
  struct Block {
    size_t size = 0, oldest = 0;
  };
  std::unordered_map<std::string_view, Block> blocks;
  const Block* largest = nullptr;
  for (size_t i = 0; i < oldest_first.size(); ++i) {
    if (!oldest_first[i].may_close) continue;
    Block& block = blocks.try_emplace(oldest_first[i].block, Block{0, i}).first->second;
    ++block.size;
    if (largest == nullptr || block.size > largest->size) largest = &block;
  }
  if (largest == nullptr) return std::nullopt;
  return largest->oldest;
}

}  // namespace enamel::server
