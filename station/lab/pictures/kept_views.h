#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "station/render/png_file.h"
#include "station/render/screen.h"

// The set views of the built-in teeth and exercises whose pictures are kept, to be compared.
namespace enamel::station::lab {

// Of a picture, pixels. Small, because many are kept: at rest and in the best quality they are as
// sharp as a window's (four samples a pixel).
inline constexpr int kKeptWidth_px = 288, kKeptHeight_px = 216;

// Draws the views of a built-in scene, as the chair draws them but without its panel:
//   SCENE.mouth        the tooth with gingiva, neighbours and antagonist, all of it seen; SCENE.whole
//                      of the block, which has none
//   SCENE.open         the tooth cut open: enamel, dentin, pulp, caries
//   EXERCISE.start     near the place to cut, with the target's outline, and the rubber dam if it
//                      has one
//   EXERCISE.target    the same with the target cut out, alone
//   SCENE.bur          a slot half cut by the first exercise's bur, which is in it
//   SCENE.mirror       the first exercise's place, with the mirror held
// Needs the screen's context current. Errors: BuildBuiltinScene's; kUnavailable where meshing does
// not end; those of `take`.
Status DrawKeptViews(
    std::string_view scene, const render::Screen& screen,
    const std::function<Status(const std::string& name, const render::Image&)>& take);

}  // namespace enamel::station::lab
