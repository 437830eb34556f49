#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace enamel::station::desk {

// `text` in lines of at most `width`, broken where people read on without stumbling: at spaces, and
// between Chinese letters; never inside a figure ("82.0"), between a figure and what it counts
// ("82.0 %"), or before a closing mark. What has no such place (a path) stays longer than `width`.
// `advance`: the width of a letter. Pure.
std::string InLines(std::string_view text, float width,
                    const std::function<float(uint32_t code)>& advance);

}  // namespace enamel::station::desk
