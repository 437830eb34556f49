#pragma once

#include <atomic>

// The signals that ask a program to end in good order: Ctrl-C and Ctrl-\, a terminal or a session that
// ends, a computer that is shut down. Also Ctrl-Z, and output or input of a program in the background,
// which would stop it with a force on.
namespace enamel::station {

// From now on these no longer end or stop the program; the first are counted. A SIGHUP that is ignored
// already (nohup) stays so. May be called again. Any thread.
void CatchStopSignals();

// How often the program was asked to end. Any thread; real-time safe.
const std::atomic<int>& StopsAsked();

}  // namespace enamel::station
