#pragma once

#include <boost/json/object.hpp>

#include "common/scene/json/read.h"
#include "common/scene/types.h"

// The parts of a wanted shape in a document: of a scene's preparations and of an exercise's target.
namespace enamel::scene {

inline constexpr size_t kMaxParts = 64, kMaxCorners = 64;

// kBoxesAndDiscs: what documents of scenes know.
enum class Outlines { kBoxesAndDiscs, kAll };

// At least 3 corners, counter-clockwise, of sides that do not cross.
bool IsOutline(const std::vector<std::array<int32_t, 2>>& corners_um);

boost::json::object PartJson(const PreparationPart& part);
// Refuses outlines that are not `known`, polygons that cross themselves or go round clockwise, and
// stumps that do not fit. Reads to the end of the object.
PreparationPart ReadPart(ObjectReader& in, Outlines known);

}  // namespace enamel::scene
