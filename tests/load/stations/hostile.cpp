#include "tests/load/stations/hostile.h"

#include "common/protocol/messages.h"

namespace enamel::load {
namespace {

constexpr double kPause_s = 1;
constexpr double kDripEvery_s = 0.5;

}  // namespace

void Hostile::Advance(double now) {
  if (link_.state() == Link::State::kClosed) {
    if (was_open_) {
      ++thrown_out_;
      was_open_ = false;
      again_s_ = now + kPause_s;
    }
    if (now < again_s_) return;
    again_s_ = now + kPause_s;
    done_ = false;
    link_.Open();
  }
  link_.Advance();
  if (link_.state() != Link::State::kOpen) return;
  was_open_ = true;
  Misbehave(now);
  if (kind_ == HostileKind::kSlowReader) return;
  for (Bytes message; link_.NextMessage(message);) {
  }
}

void Hostile::Misbehave(double now) {
  switch (kind_) {
    case HostileKind::kHalfOpen:
      return;
    case HostileKind::kSlowDrip: {
      // The length of 1000 bytes, then one of them now and then.
      if (!done_) link_.SendRaw(Bytes{0xe8, 0x03, 0, 0});
      done_ = true;
      if (now - dripped_s_ < kDripEvery_s) return;
      dripped_s_ = now;
      return link_.SendRaw(Bytes{0});
    }
    case HostileKind::kSlowReader: {
      wire::Request request;
      request.set_id(1);
      request.mutable_enrol()->set_code("guess");
      if (!done_) link_.Send(protocol::Serialize(request));
      done_ = true;
      return;
    }
    case HostileKind::kOversized:
      if (!done_) link_.SendRaw(Bytes{0xff, 0xff, 0xff, 0xff});
      done_ = true;
      return;
    case HostileKind::kGarbage: {
      if (done_) return;
      done_ = true;
      Bytes noise(200);
      for (uint8_t& byte : noise) byte = static_cast<uint8_t>(random_());
      return link_.Send(noise);
    }
  }
}

}  // namespace enamel::load
