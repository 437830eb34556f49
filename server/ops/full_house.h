#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

// Who goes when there is no room for one more connection, so that one address cannot take the place
// from everybody. Pure, any thread.
namespace enamel::server::ops {

struct Guest {
  std::string_view block;  // whom it counts for (auth::AddressBlock)
  bool may_go = false;     // has asked for nothing that is being done
};

// Of the block that has the most guests who may go, the one who came first; none: nobody may go.
std::optional<size_t> WhoMakesRoom(const std::vector<Guest>& first_come_first);

}  // namespace enamel::server::ops
