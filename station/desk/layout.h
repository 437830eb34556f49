#pragma once

#include <string>
#include <vector>

namespace enamel::station::desk {

// What a person could not read in the frame of Dear ImGui drawn last, a line each: words that a box or
// the window cuts off, words over other words, a page that is longer than its place and cannot be
// scrolled, a list with no room for a line. Words below a dialog count as covered. After
// ImGui::Render; some milliseconds.
std::vector<std::string> LayoutFaults();

}  // namespace enamel::station::desk
