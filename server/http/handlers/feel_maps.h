#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "common/fidelity/feel.h"
#include "server/storage/store_pool.h"

// Maps of what a hand can feel (common/fidelity/feel.h), computed once per device and tissues. One
// takes up to a second of a processor, so they are computed on a thread of their own, one after the
// other: neither a connection nor the store's threads wait for them.
namespace enamel::server::http {

class FeelMaps {
 public:
  using Map = std::vector<fidelity::Cell>;

  // As many are kept; the oldest goes first. A map has eight cells a tissue, some 200 bytes each.
  static constexpr size_t kKept = 64;

  // Where Of is to be called, and whatever else an answer needs that may block.
  StorePool& thread() { return thread_; }

  // The map, from memory where it was computed before. Only on `thread()`. Blocks.
  std::shared_ptr<const Map> Of(const fidelity::Device& device,
                                const std::vector<fidelity::Tissue>& tissues);
  // How many were computed so far. Only on `thread()`.
  size_t computed() const { return computed_; }

 private:
  struct Entry {
    std::string key;
    std::shared_ptr<const Map> map;
  };
  std::deque<Entry> kept_;  // oldest first
  size_t computed_ = 0;
  StorePool thread_{1};  // last: what it runs uses the others
};

}  // namespace enamel::server::http
