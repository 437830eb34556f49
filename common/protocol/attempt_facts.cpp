#include "common/protocol/attempt_facts.h"

namespace enamel::protocol {

void SetFacts(const AttemptFacts& facts, wire::OpenAttempt& message) {
  message.set_resumed(facts.resumed);
}

AttemptFacts FactsOf(const wire::OpenAttempt& message) {
  AttemptFacts facts;
  facts.resumed = message.resumed();
  return facts;
}

}  // namespace enamel::protocol
