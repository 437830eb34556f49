#include "station/desk/opening.h"

#include <utility>

#include "station/desk/station_facts.h"

namespace enamel::station::desk {
namespace {

std::filesystem::path SpoolFile(const std::filesystem::path& data) { return data / "spool.sqlite"; }

std::string WithData(const std::string& command, const std::filesystem::path& data) {
  return "enamel-station " + command + " --data " + data.string();
}

}  // namespace

// By the field first and then the code: a field has one cause, a code many. The student reads the
// first three texts and must not be frightened; the last is for the operator.
OpeningProblem OpeningProblemOf(const language::Words& words, const Status& problem,
                                const std::filesystem::path& data) {
  const std::string elsewhere = words.Say("opening.elsewhere"),
                    where_it_was = words.Say("opening.where_it_was");
  if (problem.field() == kDamagedSpool) {
    return {words.Say("opening.damaged"), words.Say("opening.damaged_safe"), elsewhere,
            problem.message() + ".\nThis saves what can be read of it into a new file:\n" +
                WithData("spool salvage --out " + (data / "saved").string(), data) +
                "\nPut it in the place of the damaged one, as that command says, keep the damaged "
                "one, then try again here."};
  }
  if (problem.field() == kLostSpool) {
    return {words.Say("opening.lost"), words.Say("opening.lost_safe"), elsewhere,
            problem.message() + ".\nPut its copy back as " + SpoolFile(data).string() +
                ", then try again here."};
  }
  if (problem.field() == kServerOption) {
    return {words.Say("opening.address"), where_it_was, elsewhere,
            problem.message() + ".\nCorrect --server, or the setting, and start it again."};
  }
  if (problem.field() == kEnrolment) {
    return {
        words.Say(problem.code() == Code::kVersion ? "opening.other_version" : "opening.enrolment"),
        where_it_was, elsewhere, problem.message() + ".\nThen try again here."};
  }
  std::error_code error;
  // Enrolling again would give it another key, and the server would reject its old recordings as
  // forged, so that must not be the first advice.
  if (problem.code() == Code::kNotFound && std::filesystem::exists(SpoolFile(data), error)) {
    return {
        words.Say("opening.forgot"), words.Say("opening.forgot_safe"), elsewhere,
        problem.message() + ".\nBefore you enrol it again: there are recordings in " +
            SpoolFile(data).string() +
            ", signed with the key that was in station.json: restore a copy of that file beside "
            "it, then try again here. Without a copy, this writes each of them to a file:\n" +
            WithData("spool export ID --out FILE", data) +
            "\nAfter enrolling again this is a different station to the server: it can be used "
            "and keeps the recordings, but the server refuses them."};
  }
  if (problem.code() == Code::kNotFound) {
    return {words.Say("opening.not_enrolled"), words.Say("opening.not_enrolled_safe"),
            words.Say("opening.until_enrolled"), problem.message() + ".\nThen try again here."};
  }
  if (problem.code() == Code::kVersion) {
    return {words.Say("opening.newer"), words.Say("opening.newer_safe"), elsewhere,
            problem.message() + "."};
  }
  return {words.Say("opening.cannot_keep"), where_it_was, elsewhere,
          problem.message() + ".\n" + WithData("doctor", data) +
              " says what else is missing. Then try again here."};
}

Opening::Opening(WorkplaceOptions options) : options_(std::move(options)) {
  auto opened = Workplace::Open(options_);
  problem_ = opened.status();
  if (opened.ok()) workplace_ = std::move(*opened);
}

std::vector<std::string> Opening::Lines() const {
  std::vector<std::string> out{problem_.message(), SpoolFile(options_.data).string()};
  if (std::string room = RoomText(FreeBytes(options_.data)); !room.empty()) out.push_back(room);
  return out;
}

void Opening::TryAgain() {
  if (busy() || workplace_) return;
  task_.Start("trouble.looking", [this]() -> BackgroundTask::After {
    // A task's outcome is copied (std::function), but a workplace cannot be.
    auto opened = std::make_shared<Result<std::unique_ptr<Workplace>>>(Workplace::Open(options_));
    return [this, opened] {
      problem_ = opened->status();
      if (opened->ok()) workplace_ = std::move(**opened);
    };
  });
}

}  // namespace enamel::station::desk
