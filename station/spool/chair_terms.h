#pragma once

namespace enamel::station {

// Terms that come with a ticket (schemas/wire/station.proto, TicketIssued). The spool keeps them until
// the attempt ends.
struct ChairTerms {
  bool sign_off = false;  // a second person signs its start and end (SignOff)
  bool outline = false;   // the person may see the target's outline on the tooth
};

}  // namespace enamel::station
