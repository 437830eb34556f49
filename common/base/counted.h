#pragma once

#include <concepts>
#include <string>
#include <string_view>

namespace enamel {

// A number of things, for people: "1 attempt", "2 attempts", "0 attempts". `many`: of a word that
// does not take an s ("people").
inline std::string Counted(std::integral auto count, std::string_view one,
                           std::string_view many = {}) {
  std::string out = std::to_string(count) + " ";
  if (count == 1) return out.append(one);
  return many.empty() ? out.append(one) + "s" : out.append(many);
}

}  // namespace enamel
