#pragma once

#include <cstring>
#include <type_traits>
#include <vector>

#include "common/base/bytes.h"

namespace enamel {

// Saves the values an object's future depends on, or puts them back: one VisitState function per
// class names its members once, for both directions. The bytes are those of this build's memory:
// good for a cache on the same machine that is checked and may be thrown away, not for a format.
// Thread safety: none. Real-time: not safe.
class StateArchive {
 public:
  // Saves.
  StateArchive() = default;
  // Restores from `saved`, which must outlive it.
  explicit StateArchive(ByteView saved) : in_(saved), saving_(false) {}

  bool saving() const { return saving_; }
  // Restoring: nothing was missing. Members visited after the first miss keep their values.
  bool ok() const { return in_.ok(); }
  // Restoring: nothing is left over either.
  bool Complete() const { return in_.ok() && in_.AtEnd(); }
  Bytes Take() { return out_.Take(); }

  template <typename... Values>
  void operator()(Values&... values) {
    (Value(values), ...);
  }

 private:
  template <typename T>
  void Value(T& value) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    Memory(&value, sizeof value);
  }
  // A vector keeps its size: it belongs to how the object was made.
  template <typename T>
  void Value(std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    Memory(values.data(), values.size() * sizeof(T));
  }
  void Memory(void* at, size_t size) {
    if (size == 0) return;
    if (saving_) {
      out_.Raw({static_cast<const uint8_t*>(at), size});
      return;
    }
    ByteView saved = in_.Raw(size);
    if (in_.ok()) std::memcpy(at, saved.data(), size);
  }

  ByteReader in_{ByteView()};
  ByteWriter out_;
  bool saving_ = true;
};

}  // namespace enamel
