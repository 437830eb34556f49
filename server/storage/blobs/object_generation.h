#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

// Of an object that several servers may write at once: a number at random in its key, so that no
// two servers write the same object, and a row that says which one counts.
namespace enamel::server {

// 63 bits, so that it is a number of SQL's; never 0.
int64_t NewGeneration();
// The text in an object's key: 16 hexadecimal digits.
std::string GenerationText(int64_t generation);
// None: it is not what GenerationText writes.
std::optional<int64_t> ReadGeneration(std::string_view text);

}  // namespace enamel::server
