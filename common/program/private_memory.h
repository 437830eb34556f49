#pragma once

namespace enamel::program {

// From here on no other process of this user can read this one's memory or take its descriptors,
// and it leaves no core: there are keys and passwords in it. Not in a build with a sanitizer, whose
// leak check does just that. Call first in main.
void KeepMemoryPrivate();

}  // namespace enamel::program
