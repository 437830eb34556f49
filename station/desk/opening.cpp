#include "station/desk/opening.h"

#include <utility>

#include "station/desk/station_facts.h"

namespace enamel::station::desk {
namespace {

constexpr char kElsewhere[] =
    "Sit down at another station, and tell whoever looks after this one. Nothing here has to be "
    "deleted, and nothing should be.";

constexpr char kWhereItWas[] = "What was recorded here before is where it was.";

std::filesystem::path SpoolFile(const std::filesystem::path& data) { return data / "spool.sqlite"; }

std::string WithData(const std::string& command, const std::filesystem::path& data) {
  return "enamel-station " + command + " --data " + data.string();
}

}  // namespace

// By the field first and the code after it: a field names one cause, a code many. Who sits here
// reads the first three texts and must not be frightened; the last is for the operator.
OpeningProblem OpeningProblemOf(const Status& problem, const std::filesystem::path& data) {
  if (problem.field() == kDamagedSpool) {
    return {"The file that keeps the recordings of this station is damaged.",
            "Every recording that the server has is safe there. Of those that only this station "
            "has, most can usually be saved.",
            kElsewhere,
            problem.message() + ".\nThis saves what can be read of it into a new file:\n" +
                WithData("spool salvage --out " + (data / "saved").string(), data) +
                "\nPut it in the place of the damaged one, as that command says, keep the damaged "
                "one, then try again here."};
  }
  if (problem.field() == kLostSpool) {
    return {"The file that keeps the recordings of this station is empty or gone.",
            "Every recording that the server has is safe there. The others are in a copy of that "
            "file, if somebody made one.",
            kElsewhere,
            problem.message() + ".\nPut its copy back as " + SpoolFile(data).string() +
                ", then try again here."};
  }
  if (problem.field() == kServerOption) {
    return {"This station was started with an address of its server that cannot be understood.",
            kWhereItWas, kElsewhere,
            problem.message() + ".\nCorrect --server, or the setting, and start it again."};
  }
  if (problem.field() == kEnrolment) {
    return {problem.code() == Code::kVersion
                ? "This station was enrolled by another version of this program."
                : "What this station needs to know its server by cannot be used as it is.",
            kWhereItWas, kElsewhere, problem.message() + ".\nThen try again here."};
  }
  std::error_code error;
  // Enrolled anew it would have another key, and the server would take its old recordings for forged:
  // that must not be the first thing that somebody tries.
  if (problem.code() == Code::kNotFound && std::filesystem::exists(SpoolFile(data), error)) {
    return {"This station does not know its server any more.",
            "The recordings made here are still here, and nothing changes them.", kElsewhere,
            problem.message() + ".\nBefore it is enrolled anew: there are recordings in " +
                SpoolFile(data).string() +
                ", signed with the key that was in station.json: put a copy of that file back "
                "beside it, then try again here. Where there is no copy, this writes each of them "
                "to a file:\n" +
                WithData("spool export ID --out FILE", data) +
                "\nEnrolled anew, this is another station to the server: it can be used again, "
                "and keeps them, but the server refuses them from it."};
  }
  if (problem.code() == Code::kNotFound) {
    return {"This station does not belong to a server yet.",
            "Nothing was recorded here that could be lost.",
            "Sit down at another station until somebody has enrolled this one.",
            problem.message() + ".\nThen try again here."};
  }
  if (problem.code() == Code::kVersion) {
    return {"The recordings of this station were made by a newer program than this one.",
            "They are safe: nothing here changes them.", kElsewhere, problem.message() + "."};
  }
  return {"This station cannot keep recordings just now.", kWhereItWas, kElsewhere,
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
  task_.Start("Looking again", [this]() -> BackgroundTask::After {
    // A task's outcome is copied (std::function), a workplace cannot be.
    auto opened = std::make_shared<Result<std::unique_ptr<Workplace>>>(Workplace::Open(options_));
    return [this, opened] {
      problem_ = opened->status();
      if (opened->ok()) workplace_ = std::move(**opened);
    };
  });
}

}  // namespace enamel::station::desk
