#pragma once

// GLSL 3.30 sources. The tooth's layer is drawn in three passes: tooth (albedo, view-space normal,
// depth), ambient occlusion at half size, and the composition: light on both, over the background.
// A processor that draws takes every way through a shader for every pixel: what is not tooth is left
// to scissors and the background to a pass of its own.
// The bur's shadow darkens what is there; the bur itself is lit as it is drawn (solid).
namespace enamel::station::render {

extern const char* const kLit;  // a function; goes before kSolidFragment and kComposeFragment
extern const char* const kToothVertex;
extern const char* const kToothFragment;
extern const char* const kSolidVertex;
extern const char* const kSolidFragment;
extern const char* const kFullScreenVertex;
extern const char* const kOcclusionFragment;
extern const char* const kBlurFragment;
extern const char* const kComposeFragment;
extern const char* const kBackgroundFragment;
extern const char* const kShadowFragment;

}  // namespace enamel::station::render
