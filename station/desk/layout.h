#pragma once

#include <span>
#include <string>
#include <vector>

#include "station/desk/ui.h"

namespace enamel::station::desk {

// What a person could not read in the frame of Dear ImGui drawn last, a line each: words that a box or
// the window cuts off, words over other words, a page that is longer than its place and cannot be
// scrolled, a list with no room for a line. Words below a dialog count as covered. `choices` are
// those of the same frame (Ui::choices): a fault is a button that is not whole, unless a list scrolls
// it, and the row in use where its list does not show it. After ImGui::Render; some milliseconds.
std::vector<std::string> LayoutFaults(std::span<const Choice> choices = {});

}  // namespace enamel::station::desk
