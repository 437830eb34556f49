#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/mutex.h"

namespace enamel::server {

// Memory that this server holds for others, party by party (a person, a station, an address): large
// answers that are being sent, requests and frames that have only begun to come. While there is more
// than `most`, what is held for whoever has most is given up, the oldest first, for somebody who has
// less. So who reads slowly, or announces much and sends nothing, harms nobody else. Parts with the
// same bytes count once. Thread safety: any thread.
class HeldBytes {
 public:
  explicit HeldBytes(size_t most) : most_(most) {}

  // A part of it: an answer, a request, a frame.
  class Held {
   public:
    // Called once, when it is given up, from any thread; must not block.
    void OnGivenUp(std::function<void()> close);

   private:
    friend class HeldBytes;
    Mutex mutex_;
    bool given_up_ ENAMEL_GUARDED_BY(mutex_) = false;
    std::function<void()> close_ ENAMEL_GUARDED_BY(mutex_);
  };
  // `of`: whose it is, `where`: names the bytes in memory. Counts until the last copy of what it
  // returns ends. Null: there is no room, and nobody else has more.
  std::shared_ptr<Held> Add(const std::string& of, const void* where, size_t bytes);
  size_t bytes() const;

  struct Use {
    std::string of;  // empty: nobody's
    size_t bytes = 0;
  };
  // Returns the party that has most now, among those whose name begins so.
  Use Most(std::string_view of_begins = {}) const;
  // Counts since the start all that found no room or was given up.
  uint64_t refused() const;

 private:
  struct Entry {
    uint64_t id;
    std::string of;
    const void* where;
    size_t bytes;
    std::weak_ptr<Held> held;
  };
  struct State {
    mutable Mutex mutex;
    std::list<Entry> entries ENAMEL_GUARDED_BY(mutex);  // the oldest first
    std::map<std::string, size_t> of ENAMEL_GUARDED_BY(mutex);
    std::map<const void*, size_t> uses ENAMEL_GUARDED_BY(mutex);
    size_t bytes ENAMEL_GUARDED_BY(mutex) = 0;
    uint64_t next_id ENAMEL_GUARDED_BY(mutex) = 0;
    uint64_t refused ENAMEL_GUARDED_BY(mutex) = 0;

    void Remove(std::list<Entry>::iterator entry) ENAMEL_REQUIRES(mutex);
    // Of whoever has most, and more than `than`; end: nobody.
    std::list<Entry>::iterator OldestOfMost(size_t than) ENAMEL_REQUIRES(mutex);
  };

  const size_t most_;
  // Answers may outlive this.
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace enamel::server
