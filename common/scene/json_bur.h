#pragma once

#include <boost/json/object.hpp>

#include "common/scene/json_read.h"
#include "common/scene/types.h"

// A bur in a document: {"shape", "radius_um", "length_um"}, as exercises and scenes both have it.
namespace enamel::scene {

// Without its name.
boost::json::object BurJson(const BurSpec& bur);
// Refuses unknown shapes (with the list) and sizes out of range. The caller reads further members
// and finishes.
BurSpec ReadBur(ObjectReader& in);

}  // namespace enamel::scene
