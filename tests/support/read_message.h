#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/system/system_error.hpp>

#include "common/protocol/frame.h"

namespace enamel::test {

// Waits for the next message of a stream of frames. Throws boost::system::system_error if the
// stream ends or has no frames.
template <typename Stream>
Bytes ReadMessage(Stream& stream) {
  protocol::FrameReader reader;
  while (!reader.done()) {
    auto space = reader.Prepare();
    size_t n = stream.read_some(boost::asio::buffer(space.data(), space.size()));
    if (!reader.Resume(n).ok()) {
      throw boost::system::system_error(boost::asio::error::message_size);
    }
  }
  return reader.Take();
}

}  // namespace enamel::test
