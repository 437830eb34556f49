#pragma once

#include <memory>

#include "station/sound/warning_tone.h"

namespace enamel::station::sound {

// Plays the handpiece's voice and warnings on the computer's loudspeaker, from its own thread, about 40 ms
// behind. Without a sound card, or built without ALSA, it is silent and nothing else changes.
// Thread safety: Set and Warn from one thread.
class Speaker {
 public:
  Speaker();
  ~Speaker();
  Speaker(const Speaker&) = delete;
  Speaker& operator=(const Speaker&) = delete;

  // As HandpieceVoice::Set. Never waits.
  void Set(double speed_krpm, double load);
  // As WarningTone::Set. Never waits.
  void Warn(Hazard hazard, double nearness);
  // Whether a sound card is playing.
  bool audible() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enamel::station::sound
