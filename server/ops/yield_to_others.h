#pragma once

namespace enamel::server::ops {

// Of the calling thread: what must not wait, taking recordings and answering people, goes first. No
// harm where it is not granted. About a third of another thread's share when all want to run.
void YieldToOthers();

}  // namespace enamel::server::ops
