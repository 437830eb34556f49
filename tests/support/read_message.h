#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/system/system_error.hpp>

#include "common/protocol/frame.h"

namespace enamel::test {

// The next message of a stream of frames; waits for it. Throws boost::system::system_error where
// the stream ends or is no stream of frames.
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
