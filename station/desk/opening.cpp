#include "station/desk/opening.h"

#include <utility>

#include "station/desk/station_facts.h"

namespace enamel::station::desk {
namespace {

constexpr char kElsewhere[] =
    "Sit down at another station, and tell whoever looks after this one. Nothing here has to be "
    "deleted, and nothing should be.";

std::string WithData(const std::string& command, const std::filesystem::path& data) {
  return "enamel-station " + command + " --data " + data.string();
}

}  // namespace

Trouble TroubleOf(const Status& problem, const std::filesystem::path& data) {
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
  return {"This station cannot keep recordings just now.",
          "What was recorded here before is where it was.", kElsewhere,
          problem.message() + ".\n" + WithData("doctor", data) +
              " says what else is missing. Then try again here."};
}

Opening::Opening(WorkplaceOptions options) : options_(std::move(options)) {
  auto opened = Workplace::Open(options_);
  problem_ = opened.status();
  if (opened.ok()) workplace_ = std::move(*opened);
}

std::vector<std::string> Opening::Lines() const {
  std::vector<std::string> out{problem_.message(), (options_.data / "spool.sqlite").string()};
  if (std::string room = RoomText(FreeBytes(options_.data)); !room.empty()) out.push_back(room);
  return out;
}

void Opening::TryAgain() {
  if (busy() || workplace_) return;
  errand_.Start("Looking again", [this]() -> Errand::After {
    auto opened = std::make_shared<Result<std::unique_ptr<Workplace>>>(Workplace::Open(options_));
    return [this, opened] {
      problem_ = opened->status();
      if (opened->ok()) workplace_ = std::move(**opened);
    };
  });
}

}  // namespace enamel::station::desk
