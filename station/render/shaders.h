#pragma once

// GLSL 3.30 sources. The picture is drawn in three passes: solid (colour, view-space normal,
// depth), ambient occlusion at half size, and the composition of both over the background.
namespace enamel::station::render {

extern const char* const kSolidVertex;
extern const char* const kSolidFragment;
extern const char* const kFullScreenVertex;
extern const char* const kOcclusionFragment;
extern const char* const kBlurFragment;
extern const char* const kComposeFragment;

}  // namespace enamel::station::render
