#pragma once

#include <memory>

namespace enamel::station::sound {

// The handpiece's voice on the computer's loudspeaker, from a thread of its own; about 40 ms
// behind. Where there is no sound card, or the program was built without ALSA, it is silent and
// nothing else changes. Thread safety: Set from one thread.
class Speaker {
 public:
  Speaker();
  ~Speaker();
  Speaker(const Speaker&) = delete;
  Speaker& operator=(const Speaker&) = delete;

  // As HandpieceVoice::Set. Never waits.
  void Set(double speed_krpm, double load);
  // A sound card takes what is played.
  bool audible() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enamel::station::sound
