#pragma once

namespace enamel::station {

// What the server says of an attempt with its ticket and the chair has to remember for as long as
// the attempt lasts (schemas/wire/station.proto, TicketIssued).
struct ChairTerms {
  bool sign_off = false;  // a second person signs its start and end (SignOff)
  bool outline = false;   // the person may see the target's outline on the tooth
};

}  // namespace enamel::station
