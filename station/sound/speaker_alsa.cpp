#include <alsa/asoundlib.h>

#include <array>
#include <atomic>
#include <thread>

#include "station/sound/handpiece_voice.h"
#include "station/sound/speaker.h"

namespace enamel::station::sound {
namespace {

constexpr unsigned kRate_hz = 48'000, kLatency_us = 40'000;
constexpr size_t kBlock = 480;  // 10 ms

// ALSA reports on standard error what it did not find; a missing sound card is not worth a message.
void Quiet(const char*, int, const char*, int, const char*, ...) {}

snd_pcm_t* OpenCard() {
  snd_lib_error_set_handler(&Quiet);
  snd_pcm_t* card = nullptr;
  if (snd_pcm_open(&card, "default", SND_PCM_STREAM_PLAYBACK, 0) < 0) return nullptr;
  if (snd_pcm_set_params(card, SND_PCM_FORMAT_FLOAT, SND_PCM_ACCESS_RW_INTERLEAVED, 1, kRate_hz, 1,
                         kLatency_us) < 0) {
    snd_pcm_close(card);
    return nullptr;
  }
  return card;
}

}  // namespace

class Speaker::Impl {
 public:
  Impl() : card_(OpenCard()), audible_(card_ != nullptr) {
    if (card_ != nullptr) thread_ = std::thread([this] { Play(); });
  }
  ~Impl() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    if (card_ != nullptr) snd_pcm_close(card_);
  }

  std::atomic<float> speed_krpm_{0}, load_{0}, nearness_{0};
  std::atomic<Hazard> hazard_{Hazard::kPulp};

  bool audible() const { return audible_; }

 private:
  void Play() {
    HandpieceVoice voice(kRate_hz);
    WarningTone warning(kRate_hz);
    std::array<float, kBlock> block{};
    while (!stop_) {
      voice.Set(speed_krpm_, load_);
      voice.Fill(block);
      warning.Set(hazard_, nearness_);
      warning.AddTo(block);
      snd_pcm_sframes_t written = snd_pcm_writei(card_, block.data(), block.size());
      if (written < 0 && snd_pcm_recover(card_, static_cast<int>(written), 1) < 0) {
        audible_ = false;  // the card was removed
        return;
      }
    }
  }

  snd_pcm_t* const card_;
  std::atomic<bool> stop_{false}, audible_;
  std::thread thread_;
};

Speaker::Speaker() : impl_(std::make_unique<Impl>()) {}
Speaker::~Speaker() = default;

void Speaker::Set(double speed_krpm, double load) {
  impl_->speed_krpm_ = static_cast<float>(speed_krpm);
  impl_->load_ = static_cast<float>(load);
}
void Speaker::Warn(Hazard hazard, double nearness) {
  impl_->hazard_ = hazard;
  impl_->nearness_ = static_cast<float>(nearness);
}
bool Speaker::audible() const { return impl_->audible(); }

}  // namespace enamel::station::sound
