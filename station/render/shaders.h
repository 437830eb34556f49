#pragma once

// GLSL 3.30 sources. The tooth's layer is drawn in three passes: tooth (albedo, view-space normal,
// depth), ambient occlusion at half size, and the composition: light on both, over the background.
// A CPU that renders takes every path of a shader for every pixel, so scissors exclude pixels off
// the tooth, and the background has its own pass. The bur's shadow darkens what is behind it; the
// bur itself is lit when it is drawn (solid).
namespace enamel::station::render {

extern const char* const kLit;    // a function; comes before kSolidFragment and kComposeFragment
extern const char* const kLooks;  // a function; comes before kToothVertex and kSolidVertex
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
extern const char* const kMirrorFragment;  // with kSolidVertex

}  // namespace enamel::station::render
