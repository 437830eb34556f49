#include "station/session/prepared_attempt.h"

namespace enamel::station {

Status UseHandOf(PreparedAttempt& prepared, const Device& device) {
  if (prepared.header.params.spring_on_board && !device.runs_spring()) {
    return Status(Code::kConflict,
                  "device profile '" + prepared.profile.name +
                      "' leaves the spring to the device's board (board_spring), and " +
                      device.Name() + " has no such board: choose another device or profile",
                  "board_spring");
  }
  const Hand hand = device.hand();
  ENAMEL_RETURN_IF_ERROR(MayHold(prepared.hands, hand, true));
  const Hand& begun = prepared.header.hand;
  if (!prepared.core) {
    prepared.header.hand = hand;
    return Status::Ok();
  }
  // Its header is recorded and fixed: a recording by two kinds of hand would claim only one.
  if (begun.kind == hand.kind) return Status::Ok();
  return Status(Code::kConflict,
                "this attempt was begun with " + HandText(begun) + ", found " + HandText(hand) +
                    "; resume it with the same kind",
                "hand");
}

}  // namespace enamel::station
