#pragma once

#include <functional>
#include <string>
#include <string_view>

struct ImFont;

namespace enamel::station::render {

// `text` in lines of at most `width`, broken where people read on without stumbling: at spaces, and
// between Chinese letters; never inside a figure ("82.0"), between a figure and what it counts
// ("82.0 %"), before a closing mark, or so that a single Chinese letter makes the last line. What has
// no such place (a path) stays longer than `width`. `advance`: the width of a letter. Pure.
std::string InLines(std::string_view text, float width,
                    const std::function<float(uint32_t code)>& advance);
std::string InLines(std::string_view text, float width, const ImFont& font);

// In as many lines, all of about the same length: a last one of one word would look forgotten.
std::string InEvenLines(std::string_view text, float width,
                        const std::function<float(uint32_t code)>& advance);
std::string InEvenLines(std::string_view text, float width, const ImFont& font);

// Tells the window that begins next, which resizes itself, the size of its content, pixels. Otherwise it has the size
// of the frame before, and cuts off words that have just become longer.
void FitNextWindow(float width, float height);

}  // namespace enamel::station::render
