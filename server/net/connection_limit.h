#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

// Which connection is closed for one more when there are as many as there may be, so that one
// address cannot take every place. Pure, any thread.
namespace enamel::server {

struct Closable {
  std::string_view block;  // the address it counts for (auth::AddressBlock)
  bool may_close = false;  // nothing that it asked for is being done
};

// Index of the oldest connection of the block that has the most of those that may be closed; none
// when there is no such connection. Equal blocks: the one whose oldest is older.
std::optional<size_t> PickToClose(const std::vector<Closable>& oldest_first);

}  // namespace enamel::server
