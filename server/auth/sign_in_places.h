#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <unordered_set>

#include "common/base/mutex.h"
#include "server/storage/store_pool.h"

namespace enamel::server::auth {

// Shares out the turns at the hashing threads, so that no flood of guesses keeps out anybody else.
//
//   who                                              takes turns with             may wait
//   a login that has signed in from this place, or   such logins, which get       two at once
//   is known there (Line::kFirst)                    every other turn
//   another login                                    the other places of its      `of_place`
//                                                    line
//
// A place is an AddressSite or a party (Origin). A party takes turns as one, whatever the login, and
// has one thread: a hash takes 64 MiB. "Has signed in" is since the server began: at most 20 000
// logins. While kMost wait, a place has kAlways more. Thread safety: any thread.
class SignInPlaces {
 public:
  explicit SignInPlaces(size_t of_place) : of_place_(of_place) {}

  // None: there is no place, it has to come again.
  std::optional<Turn> Take(const std::string& login, const std::string& place, Line line,
                           bool is_party = false);
  // Of a Take.
  void Leave(const Turn& turn);
  // The login has signed in from there.
  void Know(const std::string& login, const std::string& place);

  static constexpr size_t kMaxOfLogin = 2, kAlways = 4, kMost = 256;

 private:
  static constexpr size_t kMaxKnown = 20'000;

  const size_t of_place_;
  Mutex mutex_;
  size_t others_ ENAMEL_GUARDED_BY(mutex_) = 0;  // that wait and do not go first
  std::map<std::string, size_t> waiting_ ENAMEL_GUARDED_BY(mutex_);  // by Turn::of
  std::unordered_set<std::string> known_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server::auth
