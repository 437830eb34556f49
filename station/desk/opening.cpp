#include "station/desk/opening.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "common/base/file.h"
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
  if (problem.field() == kWindowOpen) {
    return {words.Say("opening.window"), words.Say("opening.window_safe"),
            words.Say("opening.window_todo"), problem.message() + "."};
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
  problem_ = Lock();
  if (!problem_.ok()) return;
  auto opened = Workplace::Open(options_);
  problem_ = opened.status();
  if (opened.ok()) workplace_ = std::move(*opened);
}

// flock rather than a file's existence: the system releases it when the program ends, in any way.
Status Opening::Lock() {
  if (lock_) return Status::Ok();
  const std::filesystem::path path = options_.data / "window.lock";
  auto file = std::make_unique<Fd>(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  // No folder, or one that cannot be written: the workplace says so better.
  if (file->get() < 0) return Status::Ok();
  // A file system that knows no locks is no reason to refuse the window.
  if (::flock(file->get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    const auto pid = ReadFile(path, 32);
    return Status(Code::kConflict,
                  "process " + (pid.ok() ? std::string(AsText(*pid)) : std::string("?")) +
                      " has the window of " + options_.data.string() +
                      " open. A second window needs a folder of its own (--data); commands work "
                      "beside it",
                  kWindowOpen);
  }
  // For the message above only.
  const std::string pid = std::to_string(::getpid());
  if (::ftruncate(file->get(), 0) == 0) (void)!::write(file->get(), pid.data(), pid.size());
  lock_ = std::move(file);
  return Status::Ok();
}

std::vector<std::string> Opening::Lines() const {
  std::vector<std::string> out{problem_.message(), SpoolFile(options_.data).string()};
  if (std::string room = RoomText(FreeBytes(options_.data)); !room.empty()) out.push_back(room);
  return out;
}

void Opening::TryAgain() {
  if (busy() || workplace_) return;
  problem_ = Lock();
  if (!problem_.ok()) return;
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
