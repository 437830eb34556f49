#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>

#include "common/base/mutex.h"

namespace enamel::server::http {

// Memory of large answers that are being sent. While there is more than `most`, answers of whoever
// has most are given up, the oldest first, for one of somebody who has less: so slow readers harm
// nobody else. Answers with the same body count once. Thread safety: any thread.
class UnsentBytes {
 public:
  explicit UnsentBytes(size_t most) : most_(most) {}

  // An answer that is being sent.
  class Sending {
   public:
    // Called once, when it is given up, from any thread; must not block.
    void OnGivenUp(std::function<void()> close);

   private:
    friend class UnsentBytes;
    Mutex mutex_;
    bool given_up_ ENAMEL_GUARDED_BY(mutex_) = false;
    std::function<void()> close_ ENAMEL_GUARDED_BY(mutex_);
  };
  // `of`: whose it is, `body`: names the bytes in memory. Counts until the last copy of what it
  // returns ends. Null: there is no room, and nobody else has more.
  std::shared_ptr<Sending> Add(const std::string& of, const void* body, size_t bytes);
  size_t bytes() const;

 private:
  struct Entry {
    uint64_t id;
    std::string of;
    const void* body;
    size_t bytes;
    std::weak_ptr<Sending> sending;
  };
  struct State {
    mutable Mutex mutex;
    std::list<Entry> entries ENAMEL_GUARDED_BY(mutex);  // the oldest first
    std::map<std::string, size_t> of ENAMEL_GUARDED_BY(mutex);
    std::map<const void*, size_t> uses ENAMEL_GUARDED_BY(mutex);
    size_t bytes ENAMEL_GUARDED_BY(mutex) = 0;
    uint64_t next_id ENAMEL_GUARDED_BY(mutex) = 0;

    void Remove(std::list<Entry>::iterator entry) ENAMEL_REQUIRES(mutex);
    // Of whoever has most, and more than `than`; end: nobody.
    std::list<Entry>::iterator OldestOfMost(size_t than) ENAMEL_REQUIRES(mutex);
  };

  const size_t most_;
  // Answers may outlive this.
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace enamel::server::http
