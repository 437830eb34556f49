#pragma once

// GLSL 3.30 sources. The tooth's layer is drawn in three passes: solid (colour, view-space normal,
// depth), ambient occlusion at half size, and the composition of both over the background. The
// bur's shadow darkens what is there.
namespace enamel::station::render {

extern const char* const kSolidVertex;
extern const char* const kSolidFragment;
extern const char* const kFullScreenVertex;
extern const char* const kOcclusionFragment;
extern const char* const kBlurFragment;
extern const char* const kComposeFragment;
extern const char* const kShadowFragment;

}  // namespace enamel::station::render
