#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "common/program/example.h"
#include "common/program/log.h"
#include "common/scene/find_profile.h"
#include "station/lab/bench/bench.h"
#include "station/lab/devices/emulated_inverse3.h"
#include "station/loop/realtime.h"
#include "station/sdk/open_sdk_device.h"
#include "station/session/device_delay.h"

// How long a device takes that answers to forces, and what that makes of its delay.
namespace enamel::station::lab::bench {
namespace {

constexpr int64_t kAnswersRate_hz = 1000;

struct AnswersOptions {
  double seconds = 10;
  int delay_us = 0, jitter_us = 0;
  std::string device, profile = "inverse3", json;
};

// An exchange a tick, as in an attempt, always with force 0.
scene::AnswerTime Exchange(Device& device, double seconds) {
  RealtimeGrant grant = RequestRealtime();
  if (!grant.refused.empty()) program::SayWarning(grant.refused);
  const auto ticks = static_cast<int64_t>(seconds * kAnswersRate_hz);
  auto due = std::chrono::steady_clock::now();
  Progress progress;
  for (int64_t i = 0; i < ticks; ++i) {
    due += std::chrono::milliseconds(1);
    std::this_thread::sleep_until(due);
    (void)device.ReadSample();
    device.SendForce(dvec3(0));
    if (i % 100 == 0) progress.Show("asking", static_cast<double>(i) / static_cast<double>(ticks));
  }
  return device.answer_time().value_or(scene::AnswerTime{});
}

Status MeasureAnswers(const AnswersOptions& options, Rows& rows) {
  ENAMEL_ASSIGN_OR_RETURN(const auto profile, scene::FindProfile(options.profile));
  std::optional<EmulatedInverse3> service;
  hid::DeviceChoice choice;
  choice.device = options.device;
  choice.thread_setup = [] { (void)RequestRealtime(); };
  if (options.device.empty()) {
    service.emplace();
    service->Delay(std::chrono::microseconds(options.delay_us),
                   std::chrono::microseconds(options.jitter_us));
    choice.device = service->choice();
  }
  ENAMEL_ASSIGN_OR_RETURN(auto device,
                          sdk::OpenChosenDevice(choice, profile, 1.0 / kAnswersRate_hz));
  const scene::AnswerTime answers = Exchange(*device, options.seconds);
  if (answers.answers == 0) {
    return Status(Code::kInvalidInput, device->Name() + " does not answer to forces", "device");
  }
  const auto delay = scene::DelayOfAttached(profile, nullptr, kAnswersRate_hz, answers);
  ENAMEL_ASSIGN_OR_RETURN(const auto delayed,
                          scene::WithDelay(profile, kAnswersRate_hz, delay.ticks));
  const int64_t kc = delayed.coupling_mn_per_mm.value;
  std::printf("%lld answers: median %lld us, p99 %lld us, jitter (p99 - median) %lld us\n",
              static_cast<long long>(answers.answers), static_cast<long long>(answers.median_us),
              static_cast<long long>(answers.p99_us),
              static_cast<long long>(answers.p99_us - answers.median_us));
  std::printf("Profile %s says %lld ticks of delay; with these answers: %lld, Kc %lld mN/mm.\n",
              profile.name.c_str(), static_cast<long long>(profile.bus_delay_ticks.value),
              static_cast<long long>(delay.ticks), static_cast<long long>(kc));
  rows.Add({{"device", device->Name()},
            {"emulated", service.has_value()},
            {"answers", answers.answers},
            {"median_us", answers.median_us},
            {"p99_us", answers.p99_us},
            {"profile", profile.name},
            {"profile_delay_ticks", profile.bus_delay_ticks.value},
            {"delay_ticks", delay.ticks},
            {"coupling_mn_per_mm", kc}});
  return Status::Ok();
}

int RunAnswers(const AnswersOptions& options) {
  if (!CanWrite(options.json)) return 1;
  const std::string method =
      "one exchange a tick at 1 kHz with force 0, as in an attempt; from the force's sending to "
      "the "
      "whole answer, one that did not come counting as long as it was waited for" +
      (options.device.empty() ? ". The service is emulated, on loopback: it answers " +
                                    std::to_string(options.delay_us) + " to " +
                                    std::to_string(options.delay_us + options.jitter_us) +
                                    " us after its request, and the time of a USB line is not in it"
                              : std::string());
  std::printf("Method: %s.\n\n", method.c_str());
  Rows rows("answers", method);
  if (Status status = MeasureAnswers(options, rows); !status.ok()) {
    program::SayError(status.message());
    return 1;
  }
  return rows.Write(options.json);
}

}  // namespace

void RegisterAnswers(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<AnswersOptions>();
  CLI::App* answers = app.add_subcommand(
      "answers", "Delay and jitter of a device that answers to forces, such as an Inverse3");
  answers->add_option("--device", options->device,
                      "A driver that 'enamel-station devices' lists, such as inverse3 or "
                      "inverse3:HOST:PORT; else an Inverse3's service is emulated");
  answers->add_option("--profile", options->profile, "Device profile")->capture_default_str();
  answers->add_option("--delay-us", options->delay_us, "The emulated service answers so late")
      ->check(CLI::Range(0, 10'000))
      ->capture_default_str();
  answers->add_option("--jitter-us", options->jitter_us, "and up to so much later, evenly spread")
      ->check(CLI::Range(0, 10'000))
      ->capture_default_str();
  answers->add_option("--seconds", options->seconds, "Of exchanges")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  answers->add_option("--json", options->json, "Write the rows to this file");
  program::AddExamples(*answers, {"--seconds 10"});
  answers->callback([options, exit_code] { *exit_code = RunAnswers(*options); });
}

}  // namespace enamel::station::lab::bench
