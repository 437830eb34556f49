#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <random>
#include <string>

#include "common/base/bytes.h"

namespace enamel::station::lab {

// A device of a published protocol, as bytes on the transport that its driver opens, and the ways in which
// it can fail: it answers each request with its pose. Thread safety: all of it.
class EmulatedArm {
 public:
  virtual ~EmulatedArm() = default;
  // As DeviceChoice::device names it, and its profile.
  virtual std::string choice() const = 0;
  virtual const char* profile() const = 0;
  // Puts the tip about 40 um times `steps` below where it began.
  virtual void Lower(int steps) = 0;
  // What the motors were told last, in the protocol's own unit and axes.
  virtual std::array<int, 3> told() const;
  uint64_t requests() const { return requests_; }
  virtual size_t answer_bytes() const = 0;

  // The requests from now on have no answer.
  void Mute(bool mute) { mute_ = mute; }
  // Requests are taken so long after they came, one at a time, evenly spread from `delay` to `delay` +
  // `jitter`.
  void Delay(std::chrono::microseconds delay, std::chrono::microseconds jitter);
  // After so many more bytes of answers no more come.
  void CutAfter(size_t bytes);
  bool is_cut() const { return cut_; }
  // Answers from now on are noise of the same length.
  void Garble(bool garble) { garble_ = garble; }
  // The cable is pulled, and put back.
  virtual void Unplug() = 0;
  virtual void Plug() = 0;
  // Its power is switched off and on. Somebody makes it usable again, where it needs a hand.
  virtual void SwitchOff() { Unplug(); }
  virtual void SwitchOn() { Plug(); }
  // After Unplug: another unit of its kind is in its place. False: nothing tells two units apart.
  virtual bool PlugOther() { return false; }

 protected:
  // The part of an answer that still gets through; to be called under mutex_.
  Bytes Through(Bytes answer);
  bool is_garbled() const { return garble_; }
  // How long the next request waits; not to be called under mutex_.
  std::chrono::microseconds Wait();

  mutable std::mutex mutex_;
  std::array<int, 3> told_{};
  std::atomic<uint64_t> requests_{0};
  std::mt19937 random_{39};  // under mutex_

 private:
  std::atomic<bool> mute_{false}, cut_{false}, garble_{false};
  size_t left_ = SIZE_MAX;  // bytes until the cut
  std::chrono::microseconds delay_{0}, jitter_{0};
};

}  // namespace enamel::station::lab
