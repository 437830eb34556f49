#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <unordered_set>

#include "common/base/mutex.h"

namespace enamel::server::auth {

// Shares out the places of sign-ins that wait to be hashed, so that no flood of guesses keeps out
// those who have signed in before.
//
//   who                                              may take
//   a login that has signed in from this block       any place, two of them at once
//   another login, from a block where one has        of two thirds, up to half of all
//   another login, from a block where none has       of two thirds, while the block has less than
//                                                    half of those that are free
//
// "Before" is since the server began: at most 20 000 logins and blocks. Thread safety: any thread.
class SignInPlaces {
 public:
  explicit SignInPlaces(size_t all) : all_(all), for_unknown_(all - all / 3) {}

  bool Take(const std::string& login, const std::string& block);
  // Of a Take that returned true.
  void Leave(const std::string& login, const std::string& block);
  // The login has signed in from there.
  void Know(const std::string& login, const std::string& block);

 private:
  static constexpr size_t kMostKnown = 20'000, kMostOfLogin = 2;

  const size_t all_, for_unknown_;
  Mutex mutex_;
  size_t taken_ ENAMEL_GUARDED_BY(mutex_) = 0;
  // By block; by login and block.
  std::map<std::string, size_t> from_ ENAMEL_GUARDED_BY(mutex_);
  std::map<std::string, size_t> of_ ENAMEL_GUARDED_BY(mutex_);
  std::unordered_set<std::string> known_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server::auth
