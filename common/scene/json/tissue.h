#pragma once

#include <boost/json.hpp>

#include "common/scene/json/read.h"
#include "common/scene/types.h"

// The cutting law of a tissue, as scenes and materials write it: damping_mn_s_per_mm, and further members where the force
// is not B v alike in all directions. Functions, any thread.
namespace enamel::scene {

// Fills the law and does not change `spec.tissue`. Refuses what a tissue cannot be by the member's name.
void ReadTissueLaw(ObjectReader& in, TissueSpec& spec);
// Members of the default are left out, so that a scene without them has the text, and the address, that it had.
void WriteTissueLaw(const TissueSpec& spec, boost::json::object& out);

}  // namespace enamel::scene
