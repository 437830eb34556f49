#pragma once

#include <set>
#include <string>
#include <string_view>

#include "common/base/sha256.h"

namespace enamel::server::app {

// Takes out of a text what names a person or a school or opens a door, for whoever is shown it:
// known names and hosts, whatever is between quotation marks, addresses of mail and network, and
// long runs of letters and digits, among which are all tokens, keys and hashes. Ids become others,
// the same ones for the same ids in one Scrubber. Times, words and numbers stay. Thread safety:
// const, any thread.
class Scrubber {
 public:
  // `names`: logins, and names of people, cohorts and stations; in any case. Those of one character
  // are left alone. `hosts`: names of computers, in any case. With one of a domain go all of it
  // ("www.example.edu" with "enamel.example.edu"), and its first label unless that names nobody
  // ("enamel", "server").
  explicit Scrubber(std::set<std::string> names, const std::set<std::string>& hosts = {});

  // `quoted`: what is between quotation marks goes too.
  std::string Scrubbed(std::string_view text, bool quoted = true) const;

 private:
  std::string Word(std::string_view word) const;
  bool IsHost(std::string_view word) const;
  std::string OtherId(std::string_view id) const;

  std::set<std::string> names_;    // in lower case; those of several words too
  std::set<std::string> hosts_;    // first labels, in lower case
  std::set<std::string> domains_;  // in lower case, of two labels or more
  Sha256 salt_;
};

}  // namespace enamel::server::app
