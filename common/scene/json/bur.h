#pragma once

#include <boost/json/object.hpp>

#include "common/scene/json/read.h"
#include "common/scene/types.h"

// A bur in a document: {"shape", "radius_um", "length_um"} and, where they are not 0,
// "narrow_radius_um", "shank_radius_um" and "neck_um", as exercises and scenes both have it.
namespace enamel::scene {

// Without its name.
boost::json::object BurJson(const BurSpec& bur);
// Refuses unknown shapes (with the list), sizes out of range and proportions that are no bur's. The
// caller reads further members and finishes.
BurSpec ReadBur(ObjectReader& in);
// The same with "iso_number", as an exercise's bur may have it.
boost::json::object NumberedBurJson(const BurSpec& bur);
// Also refuses a number whose size is not the bur's. Finishes.
BurSpec ReadNumberedBur(ObjectReader in);

}  // namespace enamel::scene
