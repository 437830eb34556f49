#pragma once

#include <vector>

#include "station/render/png_file.h"

// How different two pictures look to a person who alternates between them: FLIP, after Andersson,
// Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for Alternating
// Images", Proc. ACM on Computer Graphics and Interactive Techniques 3(2), 2020. It blurs both as
// the eye does (contrast sensitivity by channel), takes the distance of colours (HyAB in
// Hunt-adjusted L*a*b*), and raises it where edges or points differ. Unlike a similarity of
// structure it sees a change of hue alone.
namespace enamel::station::lab {

// By pixel, 0 (the same) to 1; rows as in the pictures. Requires: equal sizes.
// `pixels_per_degree`: of the viewer's field.
std::vector<float> Flip(const render::Image& kept, const render::Image& now,
                        double pixels_per_degree);

// The largest mean of `map` over a square of `side` pixels that is inside it, and the square's
// middle, in the map's rows. Requires: the square fits.
struct WorstPlace {
  double mean = 0;
  int x = 0, y = 0;
};
WorstPlace WorstOf(const std::vector<float>& map, int width, int side);

}  // namespace enamel::station::lab
